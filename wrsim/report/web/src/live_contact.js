// A wheel in one's hand on its rail: pressures, patches and forces of two contact models beside each other.
import { painted } from "./canvas.js";
import { $, press, words } from "./controls.js";
import { ticks } from "./history.js";
import { Loop, Program, Record, ground, slider } from "./live.js";
import { Section } from "./section.js";
import { unpackAll } from "./unpack.js";
import { Wheel, outlineOf, poseOf } from "./wheel.js";

const COLOURS = ["#0072b2", "#d55e00"]; // of the two models
const SCALES = [100, 200, 300, 500, 750, 1000, 1500, 2000, 3000, 5000, 10000]; // ends of the scale of pressure [MPa]
const TRACED = [["p0", "p0 [MPa]"], ["range", "\u0394\u03b3 [\u00b0]"], ["area", "area [mm\u00b2]"]];
const UNMET = 8 | 16 | 32 | 512 | 2048, ABOVE = 0.02, FAR = 2e-4;
const DEGREES = 180 / Math.PI;
const scaleOf = (values, value) => values.find((v) => v >= value) ?? values.at(-1);

const SLIDERS = [
  { id: "shift", words: "Shift", unit: "mm", least: -12, most: 12, step: 0.01, per: 1e-3, title: "Outward from the place at nominal gauge: the flange comes to the rail" },
  { id: "load", words: "Load", unit: "kN", least: 0.5, most: 250, step: 0.5, per: 1e3, title: "Vertical force of the wheel on the rail" },
  { id: "height", words: "Height", unit: "mm", least: -3, most: 10, step: 0.001, per: 1e-3, title: "Of the tape circle above the crown of the rail" },
  { id: "yaw", words: "Yaw", unit: "mrad", least: -40, most: 40, step: 0.1, per: 1e-3, title: "Angle of attack, about the wheel's own origin" },
  { id: "roll", words: "Roll", unit: "mrad", least: -40, most: 40, step: 0.1, per: 1e-3, title: "About the track, about the wheel's own origin; positive: outer side up" },
  { id: "mu", words: "Friction", unit: "", least: 0, most: 0.8, step: 0.01, per: 1, title: "Coefficient of friction everywhere on the rail" },
  { id: "xi", words: "Longitudinal creepage", unit: "\u2030", least: -20, most: 20, step: 0.05, per: 1e-3, title: "The wheel turns by this share slower than rolling at the tape circle; negative: it drives" },
  { id: "eta", words: "Lateral creepage", unit: "\u2030", least: -20, most: 20, step: 0.05, per: 1e-3, title: "Velocity of the wheel outward over its speed" },
  { id: "phi", words: "Spin", unit: "1/m", least: -1, most: 1, step: 0.01, per: 1, title: "Turning of the wheel about the vertical over its speed" },
];

/** Lobes in runs of strips that touch each other: points [o, b, angle, pressure] in mm, degrees, MPa, closed at both ends. */
function runsOf(contact) {
  return contact.patches.filter((patch) => patch.N > 0 && patch.rows.length).flatMap((patch) => {
    const runs = [];
    patch.rows.forEach((strip, j) => {
      const last = runs.at(-1)?.at(-1);
      const joined = last && strip.s - strip.ds / 2 <= last.s + 0.5001 * last.ds;
      if (!joined) runs.push([]);
      runs.at(-1).push(Object.assign(strip, { at: 1e3 * (patch.arc_rail + strip.s), row: j }));
    });
    return runs.map((strips) => ({ strips, cells: patch.cells, count: patch.cells ? patch.cells.length / patch.rows.length : 0 }));
  });
}

function drawn({ strips }) {
  const point = (strip, off, p) => [1e3 * (strip.o + off * strip.nb), 1e3 * (strip.b - off * strip.no), angleOf(strip) / DEGREES, p];
  const [first, last] = [strips[0], strips.at(-1)];
  const points = [point(first, -first.ds / 2, 0), ...strips.map((s) => point(s, 0, s.p * 1e-6)), point(last, last.ds / 2, 0)];
  const sum = (name) => strips.reduce((t, s) => t + s.N * s[name], 0);
  return { points, N: 1e-3 * strips.reduce((t, s) => t + s.N, 0), angle: angleOf({ no: sum("no"), nb: sum("nb") }), p0: 1e-6 * Math.max(...strips.map((s) => s.p)) };
}

const angleOf = ({ no, nb }) => DEGREES * Math.atan2(-no, nb);

/** What the tables, the trace and the file have of a contact, in units for readers. A patch is what touches without a gap. */
function numbersOf(contact, runs) {
  const lobes = contact.patches.filter((p) => p.N > 0), main = lobes.reduce((best, p) => (p.N > (best?.N ?? 0) ? p : best), null);
  const sum = (name) => lobes.reduce((t, p) => t + p[name], 0);
  const spans = runs.map(({ strips }) => strips.map(angleOf)).map((angles) => [Math.min(...angles), Math.max(...angles)]);
  const [from, to] = spans.length ? [Math.min(...spans.map((s) => s[0])), Math.max(...spans.map((s) => s[1]))] : [NaN, NaN];
  return {
    N: sum("N") * 1e-3, p0: Math.max(0, ...lobes.map((p) => p.p0)) * 1e-6, area: sum("area") * 1e6, patches: runs.length,
    from, to, range: Math.max(...spans.map((s) => s[1] - s[0])),
    Y: -1e-3 * (contact.Fo ?? NaN), Q: 1e-3 * (contact.Fb ?? NaN), T: 1e-3 * (contact.Ft ?? NaN), wear: contact.wear ?? NaN,
    approach: main ? main.approach * 1e6 : NaN, xi: main ? main.xi * 1e3 : NaN, eta: main ? main.eta * 1e3 : NaN, phi: main ? main.phi : NaN,
  };
}

const ROWS = [
  ["N", "Normal force N [kN]"], ["p0", "Largest pressure p0 [MPa]"], ["area", "Contact area [mm\u00b2]"], ["patches", "Patches"],
  ["from", "Contact angle, least [\u00b0]"], ["to", "Contact angle, largest [\u00b0]"], ["range", "Range within a patch [\u00b0]"], ["Y", "Y [kN]"], ["Q", "Q [kN]"], ["T", "Force along the track [kN]"],
  ["wear", "Wear number T\u03b3 [N]"], ["approach", "Approach [\u00b5m]"], ["height", "Height [mm]"], ["xi", "Longitudinal creepage [\u2030]"],
  ["eta", "Lateral creepage [\u2030]"], ["phi", "Spin [1/m]"],
];

/** The wheel on its rail, from what the program has solved. */
class LiveSection extends Section {
  constructor(canvas, colours, look) {
    super(canvas, { of: [{ patch_moment: [] }], most: 1000 }, colours, look);
  }

  set(pair, { pose }, runs, { Y, Q }) {
    this.live = { patches: runs.map(drawn).sort((a, b) => b.N - a.N), rail: pair.rail, outline: outlineOf(pair.wheel, pose).map(([o, b]) => [1e3 * o, 1e3 * b]) };
    this.forces = this.live.patches.length ? { Y, Q } : null;
    this.sections.most = scaleOf(SCALES, Math.max(0, ...this.live.patches.map((p) => p.p0)));
  }

  patches() {
    return this.live.patches;
  }

  outline() {
    return this.live.outline;
  }

  rail() {
    return this.live.rail;
  }
}

const LEVELS = 128, ALONG = 64;

/** Colours along strips, a column for every level of their largest pressure. */
function columnsOf(colours) {
  const canvas = Object.assign(document.createElement("canvas"), { width: LEVELS, height: ALONG }), g = canvas.getContext("2d");
  for (let level = 0; level < LEVELS; level++) {
    for (let k = 0; k < ALONG; k++) {
      const along = (2 * k + 1) / ALONG - 1, p = (level / (LEVELS - 1)) * Math.sqrt(1 - along * along);
      g.fillStyle = colours[Math.min(colours.length - 1, Math.floor(p * colours.length))];
      g.fillRect(level, k, 1, 1);
    }
  }
  return canvas;
}

/** One model's patches: pressure and contact angle over the curved axis above, the patches in (s, x) beneath. */
class Patches {
  constructor(canvas, colours) {
    Object.assign(this, { canvas, runs: [], most: 1000, zoom: 20, columns: columnsOf(colours) });
  }

  draw(look) {
    painted(this.canvas, (g, width, height) => this.paint(g, width, height, look));
  }

  paint(g, width, height, look) {
    g.fillStyle = look.paper;
    g.fillRect(0, 0, width, height);
    g.font = "11px sans-serif";
    g.textAlign = "left";
    if (!this.runs.length) return write(g, "no contact", width / 2 - 28, height / 2, look.quiet);
    const left = 40, right = 36, top = 22, split = Math.round(0.44 * height), GAP = 1.5;
    // patches far from each other are drawn with a gap of GAP between them
    const tiles = this.runs.map(({ strips }) => [strips[0].at - 500 * strips[0].ds, strips.at(-1).at + 500 * strips.at(-1).ds]);
    const order = tiles.map((_, i) => i).sort((i, j) => tiles[i][0] - tiles[j][0]);
    let end = null, moved = 0;
    const shift = [];
    for (const i of order) {
      if (end !== null) moved += Math.max(tiles[i][0] - end - GAP, 0);
      end = tiles[i][1];
      shift[i] = moved;
    }
    const first = tiles[order[0]][0], wide = end - moved - first;
    const long = 2e3 * Math.max(...this.runs.flatMap(({ strips }) => strips.map((s) => s.a)));
    this.zoom = [60, 40, 30, 20, 15, 10, 8, 6, 5, 4].find((z) => z * wide <= width - left - right && z * long <= height - split - 34) ?? 2.5;
    const x0 = left + (width - left - right - wide * this.zoom) / 2, middle = split + (height - split - 14) / 2;
    const X = (s, i) => x0 + (s - shift[i] - first) * this.zoom, Y = (x) => middle - 1e3 * x * this.zoom;
    const angles = this.runs.flatMap(({ strips }) => strips.map(angleOf));
    const [low, high] = [Math.floor(Math.min(0, ...angles) / 5) * 5, Math.ceil(Math.max(5, ...angles) / 5) * 5];
    const P = (p) => split - 8 - ((p * 1e-6) / this.most) * (split - 8 - top), A = (a) => split - 8 - ((a - low) / (high - low)) * (split - 8 - top);
    write(g, "p [MPa]", 4, 11, look.ink);
    g.textAlign = "right";
    write(g, "\u03b3 [\u00b0]", width - 4, 11, look.Y);
    for (const v of ticks(0, this.most, 3)) (g.textAlign = "right"), write(g, String(v), left - 4, P(v * 1e6) + 4, look.quiet), rule(g, left, P(v * 1e6), width - right, look.faint);
    g.textAlign = "left";
    for (const v of ticks(low, high, 3)) write(g, `${v}`.replace("-", "\u2212"), width - right + 4, A(v) + 4, look.Y);
    this.runs.forEach(({ strips, cells, count }, i) => {
      const edges = tiles[i], s = [edges[0], ...strips.map((t) => t.at), edges[1]];
      line(g, s.map((v, k) => [X(v, i), P(strips[k - 1]?.p ?? 0)]), look.ink, 1.6);
      line(g, strips.map((t) => [X(t.at, i), A(angleOf(t))]), look.Y, 1.6);
      const rim = (side) => strips.map((t) => [X(t.at, i), Y(t.x + side * t.a)]);
      g.save();
      line(g, [[X(edges[0], i), Y(strips[0].x)], ...rim(1), [X(edges[1], i), Y(strips.at(-1).x)], ...rim(-1).reverse(), [X(edges[0], i), Y(strips[0].x)]], look.ink, 2);
      g.clip(); // half of the rim lies outside of it
      for (const strip of strips) this.strip(g, strip, X(strip.at, i), Y);
      if (count) this.sliding(g, strips, (at) => X(at, i), Y, cells, count);
      g.restore();
    });
    const bar = [10, 5, 2, 1, 0.5].find((b) => b * this.zoom < 0.3 * width) ?? 0.5;
    g.textAlign = "left";
    rule(g, 8, height - 8, 8 + bar * this.zoom, look.ink, 1.5);
    write(g, `${bar} mm`, 14 + bar * this.zoom, height - 4, look.ink);
    g.textAlign = "right";
    write(g, "s \u2192 field side, x \u2191 rolling", width - 6, height - 4, look.quiet);
  }

  /** The semi-ellipse of pressure along a strip. */
  strip(g, strip, x, Y) {
    const wide = Math.max(1e3 * strip.ds * this.zoom, 0.5), level = Math.round((LEVELS - 1) * Math.min((strip.p * 1e-6) / this.most, 1));
    g.drawImage(this.columns, level, 0, 1, ALONG, x - wide / 2, Y(strip.x + strip.a), wide + 0.3, 2e3 * strip.a * this.zoom);
  }

  /** Dots, some pixels apart, in the cells that slide, from the leading edge of each strip on. */
  sliding(g, strips, X, Y, cells, count) {
    let before = -Infinity;
    strips.forEach((strip, j) => {
      const x = X(strip.at), down = Math.max(1, Math.round((4 * count) / (2e3 * strip.a * this.zoom)));
      if (x - before < 4) return;
      before = x;
      for (let k = j % 2 ? Math.floor(down / 2) : 0; k < count; k += down) {
        if (cells[strip.row * count + k] < 1 - 1e-9) continue;
        const along = 1 - (k + 0.5) * (2 / count);
        g.fillStyle = strip.p * 1e-6 * Math.sqrt(1 - along * along) > 0.5 * this.most ? "#ffffff" : "#000000";
        g.fillRect(x - 0.8, Y(strip.x + along * strip.a) - 0.8, 1.6, 1.6);
      }
    });
  }
}

/** p0, range of the contact angle and area over the shift, as far as one has been. */
class Trace {
  constructor(canvas, record) {
    Object.assign(this, { canvas, record, seen: 0, dots: document.createElement("canvas") });
  }

  draw(look, shift) {
    painted(this.canvas, (g, width, height) => this.paint(g, width, height, look, shift));
  }

  /** Limits of what has been recorded, in round numbers; anew where the record is. */
  limits() {
    const { rows } = this.record;
    if (rows[0] !== this.first || rows.length < this.seen) Object.assign(this, { first: rows[0], seen: 0, low: -1, high: 1, most: [1, 1, 1] });
    for (const row of rows.slice(this.seen)) {
      [this.low, this.high] = [Math.min(this.low, Math.floor(row.shift_mm)), Math.max(this.high, Math.ceil(row.shift_mm))];
      TRACED.forEach(([name], k) => {
        const value = Math.max(row[`${name}_1`] || 0, row[`${name}_2`] || 0), unit = 10 ** Math.floor(Math.log10(value || 1));
        this.most[k] = Math.max(this.most[k], Math.ceil(value / unit) * unit);
      });
    }
    this.seen = rows.length;
  }

  paint(g, width, height, look, shift) {
    g.fillStyle = look.paper;
    g.fillRect(0, 0, width, height);
    g.font = "11px sans-serif";
    this.limits();
    const { low, high, most, dots } = this, tall = (height - 22) / 3;
    const X = (s) => 46 + ((s - low) / (high - low)) * (width - 58);
    const bottom = (k) => (k + 1) * tall - 2, Y = (v, k) => bottom(k) - (v / most[k]) * (tall - 16);
    TRACED.forEach(([, label], k) => {
      g.textAlign = "left";
      write(g, label, 4, k * tall + 11, look.ink);
      rule(g, 46, bottom(k), width - 12, look.faint);
      g.textAlign = "right";
      write(g, words(most[k], 3), 42, k * tall + 22, look.quiet);
    });
    // dots stay where they are: each frame adds its own
    const scale = devicePixelRatio || 1, key = [width, height, low, high, ...most, scale].join();
    if (key !== this.key || this.drawn > this.seen || this.begun !== this.first) {
      Object.assign(dots, { width: width * scale, height: height * scale });
      Object.assign(this, { key, drawn: 0, begun: this.first });
    }
    const d = dots.getContext("2d");
    d.setTransform(scale, 0, 0, scale, 0, 0);
    for (const row of this.record.rows.slice(this.drawn)) {
      TRACED.forEach(([name], k) => [1, 0].forEach((m) => {
        d.fillStyle = COLOURS[m];
        if (Number.isFinite(row[`${name}_${m + 1}`])) d.fillRect(X(row.shift_mm) - 1, Y(row[`${name}_${m + 1}`], k) - 1, 2, 2);
      }));
    }
    this.drawn = this.seen;
    if (dots.width && dots.height) g.drawImage(dots, 0, 0, width, height);
    rule(g, X(shift), 0, X(shift), look.quiet, 1, height - 20);
    g.textAlign = "center";
    for (const v of ticks(low, high, 6)) write(g, `${v}`.replace("-", "\u2212"), X(v), height - 8, look.quiet);
    g.textAlign = "left";
    write(g, "shift [mm]", 4, height - 8, look.ink);
  }
}

function write(g, text, x, y, colour) {
  g.fillStyle = colour;
  g.fillText(text, x, y);
}

function line(g, points, colour, width) {
  g.strokeStyle = colour;
  g.lineWidth = width;
  g.beginPath();
  points.forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
  g.stroke();
}

const rule = (g, x, y, to, colour, width = 1, down = y) => line(g, [[x, y], [to, down]], colour, width);

class Page {
  async begin() {
    this.data = await unpackAll(JSON.parse($("data").textContent));
    const { data } = this;
    this.program = await Program.load(data.program.data);
    $("kernels").textContent = this.program.text(this.program.call.wrsim_contact_version());
    this.look = ground((look) => ((this.look = this.section.look = look), this.loop.ask()));
    this.record = new Record();
    this.section = new LiveSection($("section"), data.colours, this.look);
    this.views = data.models.map((_, m) => new Patches($(`patch-${m}`), data.colours));
    this.trace = new Trace($("trace"), this.record);
    this.state = { shift: 0, height: 0, yaw: 0, roll: 0, xi: 0, eta: 0, phi: 0, ...data.start };
    this.at = "load";
    this.model = 0;
    this.loop = new Loop(() => this.show());
    this.beginControls();
    this.beginHand();
    this.beginKeys();
    this.choose(0);
    new ResizeObserver(() => this.loop.ask()).observe($("panels"));
    this.loop.now();
  }

  beginControls() {
    const { data } = this;
    data.pairs.forEach((pair, i) => $("pair").append(new Option(pair.name, i)));
    $("pair").addEventListener("change", () => (this.choose(Number($("pair").value)), this.loop.ask()));
    this.sliders = Object.fromEntries(SLIDERS.map((about) => [about.id, { ...about, ...slider($("sliders"), about, (v) => this.set({ [about.id]: v * about.per })) }]));
    for (const button of document.querySelectorAll("[data-at]")) button.addEventListener("click", () => this.hold(button.dataset.at));
    for (const button of document.querySelectorAll("[data-hand]")) button.addEventListener("click", () => (press("hand", button.dataset.hand), (this.hand = button.dataset.hand)));
    data.models.forEach((name, i) => {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
      button.dataset.model = i;
      button.addEventListener("click", () => ((this.model = i), press("model", i), this.loop.ask()));
      $("models").append(button);
      $(`model-${i}`).textContent = $(`head-${i}`).textContent = name;
    });
    for (const { words: label, ...set } of data.cases) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: label });
      button.addEventListener("click", () => this.case(set));
      $("cases").append(button);
    }
    $("reset").addEventListener("click", () => this.set({ shift: 0, yaw: 0, roll: 0, xi: 0, eta: 0, phi: 0, ...this.data.start }));
    $("clear").addEventListener("click", () => ((this.record.rows = []), this.loop.ask()));
    $("save").addEventListener("click", () => this.record.save("contact.csv"));
    press("at", "load");
    press("hand", (this.hand = "move"));
    press("model", 0);
    this.hold("load");
  }

  /** At a load or at a height. */
  hold(at) {
    this.at = at;
    press("at", at);
    for (const id of ["load", "height"]) this.sliders[id].label.hidden = id !== at;
    this.loop.ask();
  }

  /** A case of a paper: its pair and its state. */
  case({ pair, ...set }) {
    if (this.data.pairs[pair] !== this.pair) this.choose(pair);
    this.hold("load");
    this.set({ yaw: 0, roll: 0, xi: 0, eta: 0, phi: 0, ...set });
  }

  choose(i) {
    $("pair").value = i;
    for (const wheel of this.wheels ?? []) wheel.free();
    this.pair = this.data.pairs[i];
    const segments = (of) => of.map((k) => this.data.segments[k].data);
    this.wheels = this.pair.contacts.map((of) => new Wheel(this.program, segments(of), this.data.layout));
    $("about").textContent = this.pair.about;
    this.record.rows = [];
    this.state.height = ABOVE;
  }

  set(change) {
    for (const [id, value] of Object.entries(change)) {
      const { least, most, per } = this.sliders[id];
      this.state[id] = Math.min(Math.max(value, least * per), most * per);
    }
    this.loop.ask();
  }

  /** Both contacts at the state; at a load each has its own height, sought from where the last two of the way lead. */
  solve() {
    const { state, pair } = this, load = this.at === "load" ? state.load : undefined;
    return this.wheels.map((wheel) => {
      wheel.friction = state.mu;
      const [last, before] = wheel.way ?? [], rise = last && before ? ((last.height - before.height) * (state.shift - last.shift)) / (last.shift - before.shift) : 0;
      const near = (last?.height ?? state.height) + (Math.abs(rise) < FAR ? rise : 0);
      const at = (height) => wheel.contact(poseOf(pair, { ...state, height }), load);
      if (load === undefined) return (wheel.way = null), at(state.height);
      const first = at(near), contact = first.status & UNMET ? at(ABOVE) : first;
      const here = { shift: state.shift, height: contact.pose[2] - pair.radius };
      wheel.way = [here, last?.shift === here.shift ? before : last];
      return contact;
    });
  }

  show() {
    const { state, pair } = this;
    this.contacts = this.solve();
    const runs = this.contacts.map(runsOf);
    this.numbers = this.contacts.map((c, m) => ({ ...numbersOf(c, runs[m]), height: 1e3 * (c.pose[2] - pair.radius) }));
    if (this.at === "load" && !(this.contacts[this.model].status & UNMET)) state.height = this.contacts[this.model].pose[2] - pair.radius;
    for (const [id, { set, per }] of Object.entries(this.sliders)) set(state[id] / per);
    const most = scaleOf(SCALES, Math.max(...this.numbers.map((n) => n.p0)));
    this.views.forEach((view, m) => (Object.assign(view, { runs: runs[m], most }), view.draw(this.look)));
    this.section.set(pair, this.contacts[this.model], runs[this.model], this.numbers[this.model]);
    this.section.draw();
    this.note();
    this.trace.draw(this.look, 1e3 * state.shift);
    this.tell();
  }

  note() {
    const { state, numbers } = this, per = (id) => state[id] / this.sliders[id].per;
    const row = { pair: this.pair.name, at: this.at, shift_mm: per("shift"), yaw_mrad: per("yaw"), roll_mrad: per("roll"), friction: state.mu, longitudinal_permille: per("xi"), lateral_permille: per("eta"), spin_per_m: state.phi };
    numbers.forEach((of, m) => ROWS.forEach(([name]) => (row[`${name}_${m + 1}`] = of[name])));
    const last = this.record.rows.at(-1);
    if (!last || Object.keys(row).some((name) => !Object.is(row[name], last[name]))) this.record.add(row);
  }

  tell() {
    const remark = this.contacts.map((c, m) => (c.words ? `${this.data.models[m]}: ${c.words}` : "")).filter(Boolean).join("; ");
    if ($("remark").textContent !== remark) $("remark").textContent = remark;
    const rows = ROWS.map(([name, label]) => [label, ...this.numbers.map((of) => words(of[name]))]);
    if (!this.cells) {
      this.cells = rows.map(([label]) => {
        const row = document.createElement("tr");
        row.append(Object.assign(document.createElement("th"), { textContent: label, scope: "row" }), document.createElement("td"), document.createElement("td"));
        $("numbers").append(row);
        return [...row.querySelectorAll("td")];
      });
    }
    rows.forEach(([, ...values], i) => values.forEach((value, m) => (this.cells[i][m].textContent = value)));
    clearTimeout(this.saying);
    this.saying = setTimeout(() => {
      const { p0, patches, from, to, Y, Q } = this.numbers[this.model];
      const said = patches ? `${patches} patch${patches > 1 ? "es" : ""}, p0 ${words(p0, 3)} MPa, contact angle ${words(from, 3)} to ${words(to, 3)} degrees, Y ${words(Y, 3)}, Q ${words(Q, 3)} kN` : "no contact";
      $("said").textContent = `Shift ${words(1e3 * this.state.shift, 3)} mm: ${said}`;
    }, 400);
  }

  /** Move, lift, load or turn by a distance on the screen [mm across, pixels down]. */
  drag(across, down, turns) {
    const { state } = this;
    if (turns) this.set({ yaw: state.yaw + 1e-4 * across, roll: state.roll - 1e-4 * down });
    else this.set({ shift: state.shift + 1e-3 * across, ...(this.at === "load" ? { load: state.load + 250 * down } : { height: state.height - 1e-6 * down }) });
  }

  /** Mouse, pen and finger on the section. */
  beginHand() {
    const canvas = $("section");
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (last) return;
      canvas.setPointerCapture(event.pointerId);
      const panel = this.section.panels.findLast((p) => event.offsetY >= p.top);
      last = { id: event.pointerId, x: event.clientX, y: event.clientY, per: panel.per };
    });
    canvas.addEventListener("pointermove", (event) => {
      if (last?.id !== event.pointerId) return;
      const turns = this.hand === "turn" || event.shiftKey, across = event.clientX - last.x;
      this.drag(turns ? across : across / last.per, event.clientY - last.y, turns);
      Object.assign(last, { x: event.clientX, y: event.clientY });
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (last = null));
  }

  /** Arrow keys move and load or lift, with Alt they turn; with Shift ten times as far. */
  beginKeys() {
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    $("section").addEventListener("keydown", (event) => {
      const way = ways[event.key];
      if (!way || event.ctrlKey || event.metaKey) return;
      const far = event.shiftKey ? 10 : 1, [across, down] = way.map((v) => v * far);
      if (event.altKey || this.hand === "turn") this.drag(5 * across, 5 * down, true);
      else this.drag(0.1 * across, this.at === "load" ? 4 * down : down, false);
      event.preventDefault();
    });
  }
}

const page = new Page();
window.wrsim = { page, ready: page.begin().catch((problem) => {
  $("remark").textContent = `The page cannot start in this browser: ${problem.message}`;
  throw problem;
}) };
