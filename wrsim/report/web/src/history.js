// Time histories beside the picture: one channel of the chosen wheelset or of a body over the place, with a cursor.
import { LIGHT, painted } from "./canvas.js";
import { words } from "./controls.js";

const COLOURS = ["#0072b2", "#d55e00"];
const MARGIN = { left: 58, right: 12, top: 20, bottom: 32 };

/** Round ticks, a few of them, from low to high. */
export function ticks(low, high, most) {
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * [1, 2, 5, 10].find((k) => k * power >= raw);
  const found = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9 * step; v += step) found.push(Math.abs(v) < 1e-9 * step ? 0 : v);
  return found;
}

export class History {
  constructor(canvas, run, count, look = LIGHT) {
    Object.assign(this, { canvas, run, count, look, key: "", part: 0, at: 0 });
    const { distance, time } = run;
    const moves = Math.abs(distance.data[count - 1] - distance.data[0]) > 1e-9;
    this.x = moves ? distance.data : time.data;
    this.label = moves ? "distance of the vehicle along the track [m]" : "time [s]";
  }

  /** The lines of the chosen channel: [name, colour, values(sample)]. */
  lines() {
    const channel = this.run.channels[this.key];
    if (!channel) return [];
    const row = channel.data.length / this.count, wheels = channel.dims.includes("wheel") ? 2 : 1;
    return Array.from({ length: wheels }, (_, j) => {
      const k = this.part * wheels + j;
      return [wheels > 1 ? ["left", "right"][j] : "", wheels > 1 ? COLOURS[j] : this.look.ink, (i) => channel.data[i * row + k]];
    });
  }

  draw() {
    painted(this.canvas, (...to) => this.paint(...to));
  }

  paint(g, width, height) {
    g.fillStyle = this.look.paper;
    g.fillRect(0, 0, width, height);
    const { x, count } = this, lines = this.lines();
    let low = Infinity, high = -Infinity;
    for (const [, , value] of lines) {
      for (let i = 0; i < count; i++) {
        const v = value(i);
        if (Number.isFinite(v)) [low, high] = [Math.min(low, v), Math.max(high, v)];
      }
    }
    if (low > high) return;
    // a limit is drawn when the values have come half the way to it
    const limits = (this.run.channels[this.key].limits ?? []).filter(({ value }) => high > value / 2);
    high = Math.max(high, ...limits.map(({ value }) => value));
    const reach = Math.max(high - low, 1e-6 * Math.abs(high), 1e-9);
    [low, high] = [low - 0.06 * reach, high + 0.06 * reach];
    const right = width - MARGIN.right, bottom = height - MARGIN.bottom;
    const X = (v) => MARGIN.left + ((v - x[0]) / (x[count - 1] - x[0] || 1)) * (right - MARGIN.left);
    const Y = (v) => bottom - ((v - low) / (high - low)) * (bottom - MARGIN.top);
    Object.assign(this, { X });
    g.font = "11px sans-serif";
    g.lineWidth = 1;
    const line = (a, b, c, d, colour) => {
      g.strokeStyle = colour;
      g.beginPath();
      g.moveTo(a, b);
      g.lineTo(c, d);
      g.stroke();
    };
    g.fillStyle = this.look.quiet;
    g.textAlign = "right";
    for (const v of ticks(low, high, 4)) {
      line(MARGIN.left, Y(v), right, Y(v), this.look.faint);
      g.fillText(words(v), MARGIN.left - 6, Y(v) + 4);
    }
    g.textAlign = "center";
    for (const v of ticks(x[0], x[count - 1], Math.max(3, width / 110))) {
      line(X(v), bottom, X(v), bottom + 4, this.look.quiet);
      g.fillText(words(v), X(v), bottom + 16);
    }
    g.fillText(this.label, (MARGIN.left + right) / 2, height - 3);
    for (const { value, words: told } of limits) {
      g.setLineDash([5, 4]);
      line(MARGIN.left, Y(value), right, Y(value), this.look.N);
      g.setLineDash([]);
      g.fillStyle = this.look.N;
      g.textAlign = "right";
      g.fillText(told, right, Y(value) + (Y(value) > 34 ? -4 : 12));
    }
    for (const [, colour, value] of lines) this.curve(g, colour, value, X, Y);
    const i = Math.round(this.at);
    line(X(x[i]), MARGIN.top - 4, X(x[i]), bottom, this.look.ink);
    let from = MARGIN.left;
    g.textAlign = "left";
    for (const [name, colour, value] of lines) {
      const v = value(i), told = `${name ? `${name} ` : ""}${words(v)}`;
      g.fillStyle = colour;
      g.fillText(told, from, 12);
      from += g.measureText(told).width + 18;
      if (!Number.isFinite(v)) continue;
      g.beginPath();
      g.arc(X(x[i]), Y(v), 3, 0, 6.28);
      g.fill();
    }
  }

  /** Least and largest value of every column of pixels: no peak is lost. */
  curve(g, colour, value, X, Y) {
    g.strokeStyle = colour;
    g.lineWidth = 1.3;
    g.beginPath();
    let column = null, open = false, low = 0, high = 0;
    const flush = () => {
      if (column === null) return;
      g[open ? "lineTo" : "moveTo"](column, Y(low));
      if (high !== low) g.lineTo(column, Y(high));
      open = true;
      column = null;
    };
    for (let i = 0; i < this.count; i++) {
      const v = value(i), at = Math.round(X(this.x[i]));
      if (!Number.isFinite(v)) {
        flush();
        open = false;
      } else if (at === column) [low, high] = [Math.min(low, v), Math.max(high, v)];
      else {
        flush();
        [column, low, high] = [at, v, v];
      }
    }
    flush();
    g.stroke();
  }

  /** The sample at a horizontal place of the canvas. */
  sampleAt(place) {
    let best = 0;
    for (let i = 0; i < this.count; i++) if (Math.abs(this.X(this.x[i]) - place) < Math.abs(this.X(this.x[best]) - place)) best = i;
    return best;
  }
}
