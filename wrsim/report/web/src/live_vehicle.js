// A vehicle that runs while one watches: its program works beside the page, which draws what it sends.
import { $, VehiclePage, words as short } from "./controls.js";
import { History } from "./history.js";
import { download, pngOf } from "./save.js";
import { Section } from "./section.js";
import { Stage, Track } from "./scene.js";
import { ground, slider } from "./live.js";
import { unpackAll } from "./unpack.js";
import { outlineOf } from "./wheel.js";

const SIDES = ["left", "right"], KEPT = 20000; // samples
const NEAR_EDGE = [0, 0.05, 0.2, 0.5]; // of half a strip, as in the pictures
const made = (tag, more, ...inside) => {
  const one = Object.assign(document.createElement(tag), more);
  one.append(...inside);
  return one;
};

/** One wheel on its rail as it is now. */
class LiveSection extends Section {
  constructor(canvas, profiles, colours, look) {
    const of = profiles.pairs.map(() => ({ patch_moment: [], missing: [] }));
    super(canvas, { of, at: [0], most: 1, wheelsets: [], wheels: SIDES }, colours, look);
    this.profiles = profiles;
  }

  /** frame: what the worker has sent; records: names of the numbers of lobes and strips; most: strips of a lobe. */
  take(frame, records, most) {
    Object.assign(this, { wheel: frame.wheel, pose: frame.pose });
    const lobe = Object.fromEntries(records.lobe.map((name, k) => [name, k]));
    const strip = Object.fromEntries(records.strip.map((name, k) => [name, k]));
    const [wide, long] = [records.lobe.length, records.strip.length];
    this.now = frame.counts.map((count, i) => {
      const of = (name) => frame.patches[i * wide + lobe[name]];
      const rows = Array.from({ length: count }, (_, j) => frame.strips.subarray((i * most + j) * long, (i * most + j + 1) * long));
      const points = rows.map((r) => [1e3 * r[strip.o], 1e3 * r[strip.b], Math.atan2(-r[strip.no], r[strip.nb]), 1e-6 * r[strip.p]]);
      if (!count) return { points };
      // towards an edge the pressure falls with the square root of the distance
      const ends = [0, count - 1].map((j, k) => NEAR_EDGE.map((part) => {
        const [o, b, turn, p] = points[j];
        const off = (k ? 1 : -1) * 500 * rows[j][strip.ds] * (1 - part);
        return [o + off * Math.cos(turn), b + off * Math.sin(turn), turn, p * Math.sqrt(part)];
      }));
      points.unshift(...ends[0]);
      points.push(...ends[1].reverse());
      return { points, N: 1e-3 * of("N"), angle: (180 / Math.PI) * of("angle_mean"), p0: 1e-6 * of("p0") };
    }).filter((patch) => patch.points.length);
    this.sections.most = Math.max(this.sections.most, ...this.now.map((p) => p.p0));
  }

  patches() {
    return this.now ?? [];
  }

  rail(wheel) {
    return this.curve(wheel, 1).map(([o, b]) => [1e3 * o, 1e3 * b]);
  }

  outline(wheel) {
    return outlineOf(this.curve(wheel, 0), this.pose).map(([o, b]) => [1e3 * o, 1e3 * b]);
  }

  curve(wheel, body) {
    return this.profiles.curves[this.profiles.pairs[wheel][body]];
  }
}

class LiveVehicle extends VehiclePage {
  async begin() {
    this.data = await unpackAll(JSON.parse($("data").textContent));
    const { data } = this, { places } = data;
    Object.assign(this, { playing: false, factor: 1, every: 1, skipped: 0, count: 0, frames: [], waiting: [] });
    places.bodies.count = data.bodies.length;
    places.records = { lobe: data.records.lobe.length, strip: data.records.strip.length, strips_of_lobe: data.records.lobe.indexOf("n_strips") };
    const look = ground((other) => {
      this.section.look = this.history.look = other;
      this.show();
    });
    this.beginHistory(look);
    this.section = new LiveSection($("section"), data.profiles, data.colours, look);
    this.stage = new Stage($("stage"), data.vehicle, new Track(data.track));
    $("about").textContent = data.about;
    this.beginControls();
    this.beginSliders();
    const source = new Blob([$("worker").textContent], { type: "text/javascript" });
    this.worker = new Worker(URL.createObjectURL(source));
    this.worker.onmessage = (event) => this.take(event.data);
    this.worker.onerror = (event) => this.tell(`The program cannot start in this browser: ${event.message}`);
    this.worker.postMessage({ program: data.program.data.buffer, token: data.token, places, end: data.end, wheel: data.wheel });
    await new Promise((done) => (this.begun = done));
    new ResizeObserver(() => {
      this.stage.resize();
      this.show();
    }).observe($("panels"));
    this.stage.resize();
    this.stage.view("oblique");
    this.show();
  }

  beginHistory(look) {
    const { data } = this, wheels = data.places.wheels.length, rows = new Map();
    const channel = (key, words, unit, dims, value) => rows.set(key, { words, unit, dims, value, wide: dims.includes("wheel") ? wheels : data.wheelsets.length, limits: data.limits[key] ?? [] });
    const wide = data.places.bodies.names.length, from = 1 + data.bodies.length * wide, forces = data.places.forces.names;
    const force = (name) => (row, k) => 1e-3 * row[from + k * forces.length + forces.indexOf(name)];
    const motion = (name, factor) => (row, k) => factor * row[1 + k * wide + data.places.bodies.names.indexOf(name)];
    const [Y, Q] = [force("Y"), force("Q")], both = ["wheelset", "wheel"];
    channel("Y_over_Q", "Y/Q", "", both, (row, k) => Y(row, k) / Q(row, k));
    channel("Y", "lateral force Y", "kN", both, Y);
    channel("Q", "vertical force Q", "kN", both, Q);
    channel("lateral", "lateral shift", "mm", ["wheelset"], motion("lateral", 1e3));
    channel("yaw", "yaw", "mrad", ["wheelset"], motion("yaw", 1e3));
    this.rows = rows;
    this.time = new Float64Array(KEPT);
    this.distance = new Float64Array(KEPT);
    for (const row of rows.values()) row.all = new Float32Array(KEPT * row.wide);
    this.run = { distance: { data: this.distance }, time: { data: this.time }, channels: Object.fromEntries(rows), wheelsets: data.wheelsets };
    this.history = new History($("history"), this.run, 1, look);
    this.history.label = "time since the start [s]";
    for (const [key, { words, unit }] of rows) $("channel").append(new Option(unit ? `${words} [${unit}]` : words, key));
  }

  /** Samples of the worker; of a run that grows too long every second, then every fourth, ... one is kept. */
  keep(samples) {
    for (const row of samples) {
      if (this.skipped++ % this.every) continue;
      if (this.count === KEPT) {
        for (let i = 0; i < KEPT / 2; i++) {
          this.time[i] = this.time[2 * i];
          this.distance[i] = this.distance[2 * i];
          for (const { all, wide } of this.rows.values()) all.copyWithin(i * wide, 2 * i * wide, (2 * i + 1) * wide);
        }
        this.count = KEPT / 2;
        this.every *= 2;
      }
      const i = this.count++;
      this.time[i] = row[0];
      this.distance[i] = row[1];
      for (const { all, wide, value } of this.rows.values()) for (let k = 0; k < wide; k++) all[i * wide + k] = value(row, k);
    }
  }

  take({ frame, samples, cost, memory, begun, restarted, ended, moved }) {
    const { data } = this;
    if (restarted !== undefined) {
      Object.assign(this, { count: 0, every: 1, skipped: 0 });
      this.tell(restarted && `Again from the start, after ${restarted}.`);
    }
    this.keep(samples);
    Object.assign(this, { frame, cost, memory });
    if (ended) {
      this.play(false);
      this.tell(`The run has ended at ${frame.time.toFixed(3)} s: ${ended}. Start again with other values, or make the page with a shorter step: wrsim live --step-ms ${500 * data.places.step}`);
    }
    if (begun) this.begun();
    if (moved || ended) this.waiting.shift()?.(this.read());
    if (!this.drawing) {
      this.drawing = true;
      requestAnimationFrame((now) => {
        this.drawing = false;
        this.frames.push(now);
        if (this.frames.length > 600) this.frames.shift();
        this.show();
      });
    }
  }

  tell(words) {
    $("remark").textContent = words;
  }

  /** The numbers of the last frame. */
  read() {
    const { frame, data } = this, { bodies, forces } = data.places, found = { time: frame.time, bodies: {}, wheels: [] };
    data.bodies.forEach(({ name }, i) => (found.bodies[name] = Object.fromEntries(bodies.names.map((key, k) => [key, frame.bodies[i * bodies.names.length + k]]))));
    for (let i = 0; i < data.places.wheels.length; i++) found.wheels.push(Object.fromEntries(forces.names.map((key, k) => [key, frame.forces[i * forces.names.length + k]])));
    return found;
  }

  show() {
    if (!this.frame || !this.count) return;
    const { frame, data } = this, { bodies, forces } = data.places, wide = bodies.names.length;
    const get = (i, name) => frame.bodies[i * wide + bodies.names.indexOf(name)];
    const poses = data.bodies.map(({ name, centre }, i) => [name, {
      place: get(i, "distance"), lateral: get(i, "lateral") - centre[1], vertical: get(i, "height") - centre[2],
      yaw: get(i, "yaw"), roll: get(i, "roll"), spin: frame.q[6 * i + 5], pitch: i < data.wheelsets.length ? 0 : frame.q[6 * i + 5],
    }]);
    const first = get(0, "distance") - (data.bodies[0].centre[0] - data.vehicle.reference);
    this.stage.pose(first, poses, this.factor);
    this.stage.render();
    this.section.take(frame, data.records, data.places.wheels[frame.wheel].most);
    const [Y, Q] = ["Y", "Q"].map((name) => 1e-3 * frame.forces[frame.wheel * forces.names.length + forces.names.indexOf(name)]);
    this.section.forces = { Y, Q };
    this.section.draw();
    const patches = this.section.patches().map((p) => `N ${short(p.N)} kN, contact angle ${short(p.angle)} degrees, p0 ${short(p.p0)} MPa`);
    $("section").setAttribute("aria-label", `${$("wheel").selectedOptions[0].textContent}: ${patches.join("; ") || "no contact"}`);
    this.showHistory();
    $("time-shown").textContent = `${frame.time.toFixed(2)} s, ${get(0, "distance").toFixed(1)} m, ${(3.6 * frame.speed).toFixed(1)} km/h`;
    const real = this.cost > 0 ? `${short(1 / this.cost, 2)} times real time can be had; ` : "";
    $("cost").textContent = `${real}balance left by the last step ${frame.residual.toExponential(1)} of the weight${frame.status ? `; status of the contact ${frame.status}` : ""}`;
  }

  showHistory() {
    const key = $("channel").value, { history, run, count } = this;
    run.distance.data = this.distance.subarray(0, count);
    run.time.data = history.x = this.time.subarray(0, count);
    for (const row of this.rows.values()) row.data = row.all.subarray(0, count * row.wide);
    Object.assign(history, { key, count, at: count - 1, part: this.frame.wheel >> 1 });
    history.draw();
    const { words, unit } = this.rows.get(key);
    $("history").setAttribute("aria-label", `${words}: ${history.lines().map(([name, , value]) => `${name} ${short(value(count - 1))} ${unit}`).join(", ")}`);
  }

  beginControls() {
    const { data } = this;
    $("play").addEventListener("click", () => this.play(!this.playing));
    $("step").addEventListener("click", () => this.move(1));
    $("again").addEventListener("click", () => this.worker.postMessage({ restart: true }));
    $("rate").addEventListener("change", () => this.worker.postMessage({ rate: Number($("rate").value) }));
    data.places.wheels.forEach((_, k) => $("wheel").append(new Option(`${this.called(data.wheelsets[k >> 1])}, ${SIDES[k % 2]}`, k)));
    $("wheel").value = data.wheel;
    $("wheel").addEventListener("change", () => this.worker.postMessage({ wheel: Number($("wheel").value) }));
    $("channel").addEventListener("change", () => this.show());
    this.beginCamera();
    for (const button of document.querySelectorAll("[data-save]")) {
      const what = button.dataset.save;
      button.addEventListener("click", async () => download(what === "csv" ? this.csv() : await pngOf($(what)), `${data.title}.${what === "csv" ? "csv" : `${what}.png`}`));
    }
    document.addEventListener("keydown", ({ key, target, ctrlKey, altKey, metaKey }) => {
      if (ctrlKey || altKey || metaKey || target.matches?.("select, input, button, summary")) return;
      const act = { " ": () => this.play(!this.playing), ".": () => this.move(1), Home: () => $("again").click() }[key];
      if (act) act();
    });
  }

  play(on) {
    this.playing = on;
    $("play").textContent = on ? "Pause" : "Run";
    $("play").setAttribute("aria-pressed", String(on));
    this.worker.postMessage({ playing: on });
  }

  /** So many steps; resolves to the numbers then. */
  move(steps) {
    this.play(false);
    this.worker.postMessage({ steps });
    return new Promise((done) => this.waiting.push(done));
  }

  /** What the worker is asked to change. */
  beginSliders() {
    const { data } = this, { speed, friction } = data;
    const set = (pairs) => this.worker.postMessage({ set: pairs });
    const add = (group, words, unit, least, most, value, change) => {
      const one = slider($(`${group}-sliders`), { id: "", words, unit, title: words, least, most, step: "any" }, (v) => {
        one.set(v);
        change(v);
      });
      one.set(value);
      one.label.dataset.words = words;
    };
    add("run", "Speed", "km/h", 3.6 * speed.least, 3.6 * speed.most, 3.6 * speed.value, (v) => this.worker.postMessage({ speed: v / 3.6 }));
    if (friction.places.length) add("run", "Friction of all rails", "", 0.01, 0.8, friction.value, (v) => set(friction.places.map((p) => [p, v])));
    else $("run-sliders").append(made("p", { className: "note", textContent: "Friction varies along this track, as the scenario says." }));
    for (const { words, places, values, stretch } of data.elements) {
      add("element", words, "times", 1 / stretch, stretch, 1, (v) => set(places.map((p, k) => [p, values[k] * v])));
    }
    for (const { words, unit, reach, value, place } of data.inputs) add("input", words, unit, -reach, reach, value, (v) => set([[place, v]]));
    for (const group of ["element", "input"]) $(`${group}-sliders`).parentElement.hidden = !$(`${group}-sliders`).children.length;
  }

  csv() {
    const { data, count } = this, head = ["time_s", "distance_m"], columns = [];
    for (const [key, { unit, all, wide }] of this.rows) {
      for (let k = 0; k < wide; k++) {
        const of = wide > data.wheelsets.length ? `${data.wheelsets[k >> 1]}_${SIDES[k % 2]}` : data.wheelsets[k];
        head.push(`${key}_${of}${unit ? `_${unit}` : ""}`.replace(/[^\w.]+/g, "_"));
        columns.push((i) => all[i * wide + k]);
      }
    }
    const lines = [head.join(",")];
    for (let i = 0; i < count; i++) lines.push([this.time[i], this.distance[i], ...columns.map((of) => of(i))].join(","));
    return new Blob([`${lines.join("\n")}\n`], { type: "text/csv" });
  }
}

const live = new LiveVehicle();
window.wrsim = { live, ready: live.begin().catch((problem) => {
  live.tell(`The page cannot start in this browser: ${problem.message}`);
  throw problem;
}) };
