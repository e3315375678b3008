// One wheel on its rail: the section to scale above, the patches closely beneath it.
import { LIGHT, painted } from "./canvas.js";

const WEAR = "#8e44adb0", WEAR_WORDS = "#6c2f87";
const kN = (v) => `${v.toFixed(1)} kN`.replace("-", "\u2212");
const OVERVIEW = [-88, 58, -42, 22];

export class Section {
  constructor(canvas, sections, colours, look = LIGHT) {
    Object.assign(this, { canvas, sections, colours, look, wheel: 0, moment: 0, forces: null, drawn: null });
    for (const of of sections.of) {
      of.first = [];
      of.patch_moment.forEach((m, k) => (of.first[m] ??= []).push(k));
    }
  }

  get count() {
    return (this.sections.at ?? this.sections.poses).length;
  }

  /** Patches of the chosen wheel: points [o, b, angle, pressure], force, contact angle, largest pressure. */
  patches(wheel = this.wheel, moment = this.moment) {
    const of = this.sections.of[wheel];
    const [, nodes] = of.patch.shape;
    return (of.first[moment] ?? []).map((k) => {
      const points = [];
      for (let i = 0; i < nodes; i++) {
        const at = (k * nodes + i) * 4;
        const [o, b, turn, p] = of.patch.data.subarray(at, at + 4);
        points.push([o, b, turn / 10, (p / 50) * this.sections.most]);
      }
      const [N, angle, p0] = of.patch_numbers.data.subarray(3 * k, 3 * k + 3);
      return { points, N, angle, p0 };
    });
  }

  outline(wheel, moment) {
    const of = this.sections.of[wheel];
    return of.missing.includes(moment) ? [] : this.points(of.outline, moment);
  }

  /** The rail at the moment; one alone stands for all of them. */
  rail(wheel, moment) {
    const { rail } = this.sections.of[wheel];
    return this.points(rail, rail.shape[0] === 1 ? 0 : moment);
  }

  points(outlines, moment) {
    const [, points] = outlines.shape;
    const from = moment * points * 2;
    return Array.from({ length: points }, (_, i) => [outlines.data[from + 2 * i], outlines.data[from + 2 * i + 1]]);
  }

  draw() {
    painted(this.canvas, (...to) => this.paint(...to));
  }

  paint(g, width, height) {
    g.fillStyle = this.look.paper;
    g.fillRect(0, 0, width, height);
    const aspect = (OVERVIEW[3] - OVERVIEW[2]) / (OVERVIEW[1] - OVERVIEW[0]);
    const top = Math.min(width * aspect, 0.46 * height);
    const patches = this.patches();
    this.words = [];
    this.panels = [];
    this.panel(g, [0, 0, width, top], this.around(OVERVIEW, width / top), patches, false);
    if (patches.length) this.panel(g, [0, top + 6, width, height - top - 6], this.close(patches, width / (height - top - 6)), patches, true);
    else {
      g.fillStyle = this.look.quiet;
      g.font = "14px sans-serif";
      g.textAlign = "center";
      g.fillText("no contact here", width / 2, top + (height - top) / 2);
    }
    this.key(g, width, top + 6);
  }

  /** Words whose anchor is wanted at (x, y): moved until they are inside of the panel and clear of what stands there. */
  say(g, words, x, y, size, colour) {
    const [left, top, width, height] = this.frame;
    g.font = `${size}px sans-serif`;
    const wide = g.measureText(words).width, line = size + 2;
    const [least, most] = [left + 4, left + width - 4 - wide];
    const from = Math.max(least, Math.min(g.textAlign === "right" ? x - wide : x, most));
    const free = (at) => {
      const box = [from, at - size, from + wide, at + 4];
      const clear = this.taken.every(([l, t, r, b]) => box[2] < l || box[0] > r || box[3] < t || box[1] > b);
      return box[1] >= top && box[3] <= top + height && clear ? box : null;
    };
    let box = null;
    for (let k = 0; k < 60 && !box; k++) box = free(y + (k % 2 ? 1 : -1) * Math.ceil(k / 2) * (line / 2));
    if (!box) return;
    this.taken.push(box);
    this.words.push({ words, box, panel: this.frame });
    g.textAlign = "left";
    g.lineWidth = 3;
    g.strokeStyle = `${this.look.paper}d0`;
    g.strokeText(words, from, box[1] + size);
    g.fillStyle = colour;
    g.fillText(words, from, box[1] + size);
  }

  /** A window of that width over height around a window. */
  around([left, right, low, high], ratio) {
    const width = Math.max(right - left, (high - low) * ratio), tall = width / ratio;
    const o = (left + right) / 2, b = (low + high) / 2;
    return [o - width / 2, o + width / 2, b - tall / 2, b + tall / 2];
  }

  /** A window around the largest patch and those near it, with room for the pressure above it. */
  close(patches, ratio) {
    const [first] = patches[0].points;
    const near = patches.filter((p) => Math.hypot(p.points[0][0] - first[0], p.points[0][1] - first[1]) < 25);
    const o = near.flatMap((p) => p.points.map((q) => q[0])), b = near.flatMap((p) => p.points.map((q) => q[1]));
    const [left, right, low, high] = [Math.min(...o), Math.max(...o), Math.min(...b), Math.max(...b)];
    const size = Math.max(Math.hypot(right - left, high - low) * 1.5, 3); // a narrow patch fills its window too
    const turn = (patches[0].angle * Math.PI) / 180;
    const middle = [(left + right) / 2 - 0.2 * size * Math.sin(turn), (low + high) / 2 + 0.2 * size * Math.cos(turn)];
    const half = [(size / 2) * Math.max(ratio, 1), (size / 2) * Math.max(1 / ratio, 1)];
    return [middle[0] - half[0], middle[0] + half[0], middle[1] - half[1], middle[1] + half[1]];
  }

  panel(g, [left, top, width, height], window, patches, near) {
    const per = width / (window[1] - window[0]);
    this.frame = [left, top, width, height];
    this.panels[Number(near)] = { top, per };
    this.taken = [[left, top + height - 24, left + width, top + height]];
    if (near) this.taken.push([left + width - 116, top, left + width, top + 36]);
    const X = (o) => left + (o - window[0]) * per, Y = (b) => top + (window[3] - b) * per;
    g.save();
    g.beginPath();
    g.rect(left, top, width, height);
    g.clip();
    const of = this.sections.of[this.wheel];
    const solid = (points, beyond, fill) => {
      if (!points.length) return;
      g.beginPath();
      g.moveTo(X(points[0][0]), beyond);
      points.forEach(([o, b]) => g.lineTo(X(o), Y(b)));
      g.lineTo(X(points.at(-1)[0]), beyond);
      g.closePath();
      g.fillStyle = fill;
      g.fill();
      g.strokeStyle = this.look.ink;
      g.lineWidth = 1;
      g.stroke();
    };
    const rail = this.rail(this.wheel, this.moment), wheel = this.outline(this.wheel, this.moment);
    solid(rail, top + height + 50, this.look.rail);
    solid(wheel, top - 50, this.look.wheel);
    if (of.wear) this.worn(g, of.wear, rail, wheel, X, Y, 0.12 * height, near);
    const reach = near ? 0.3 * Math.min(window[1] - window[0], window[3] - window[2]) : 0;
    for (const patch of patches) {
      const line = patch.points.map(([o, b]) => [X(o), Y(b)]);
      if (near) {
        const tips = patch.points.map(([o, b, turn, p]) => {
          const long = (reach * p) / this.sections.most;
          return [X(o - long * Math.sin(turn)), Y(b + long * Math.cos(turn))];
        });
        g.beginPath();
        [...line, ...tips.reverse()].forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
        g.closePath();
        g.fillStyle = `${this.look.paper}cc`;
        g.fill();
        g.strokeStyle = this.look.ink;
        g.lineWidth = 1;
        g.stroke();
        tips.reverse();
        g.strokeStyle = this.look.quiet;
        g.lineWidth = 0.6;
        tips.forEach(([x, y], i) => {
          g.beginPath();
          g.moveTo(...line[i]);
          g.lineTo(x, y);
          g.stroke();
        });
      }
      g.lineWidth = near ? 7 : 5;
      g.lineCap = "round";
      for (let i = 0; i + 1 < line.length; i++) {
        const p = (patch.points[i][3] + patch.points[i + 1][3]) / 2 / this.sections.most;
        g.strokeStyle = this.colours[Math.min(this.colours.length - 1, Math.floor(p * this.colours.length))];
        g.beginPath();
        g.moveTo(...line[i]);
        g.lineTo(...line[i + 1]);
        g.stroke();
      }
      for (const [px, py] of line) this.taken.push([px - 5, py - 5, px + 5, py + 5]);
    }
    this.arrows(g, patches, X, Y, (near ? 0.22 : 0.34) * height, near);
    if (near) for (const patch of patches) this.angle(g, patch, patch.points.map(([o, b]) => [X(o), Y(b)]));
    const bar = [20, 10, 5, 2, 1].find((b) => b * per < 0.35 * width) ?? 1;
    g.strokeStyle = g.fillStyle = this.look.ink;
    g.lineWidth = 1.5;
    const y = top + height - 10, x = left + 10;
    g.beginPath();
    g.moveTo(x, y);
    g.lineTo(x + bar * per, y);
    g.stroke();
    g.font = "12px sans-serif";
    g.textAlign = "left";
    g.fillText(`${bar} mm`, x + bar * per + 6, y + 4);
    g.fillStyle = this.look.quiet;
    g.textAlign = "right";
    g.fillText("field side \u2192", left + width - 8, y + 4);
    g.restore();
    g.strokeStyle = this.look.faint;
    g.lineWidth = 1;
    g.strokeRect(left + 0.5, top + 0.5, width - 1, height - 1);
  }

  /** What wears off, as bands inside of the wheel and the rail; the deepest place of each is as thick as `most`. */
  worn(g, wear, rail, wheel, X, Y, most, near) {
    g.fillStyle = WEAR;
    for (const [points, depth, way] of [[rail, wear.rail, 1], [wheel, wear.wheel, -1]]) {
      if (points.length < 2) continue;
      const inner = points.map(([o, b], i) => {
        const [p, q] = [points[Math.max(i - 1, 0)], points[Math.min(i + 1, points.length - 1)]];
        const [dx, dy] = [X(q[0]) - X(p[0]), Y(q[1]) - Y(p[1])], long = Math.hypot(dx, dy) || 1;
        const deep = (way * most * depth[i]) / 100;
        return [X(o) - (dy / long) * deep, Y(b) + (dx / long) * deep];
      });
      g.beginPath();
      [...points.map(([o, b]) => [X(o), Y(b)]), ...inner.reverse()].forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
      g.closePath();
      g.fill();
    }
    if (near) return;
    const [left, top] = this.frame;
    g.textAlign = "left";
    this.say(g, wear.words, left + 8, top + 16, 12, WEAR_WORDS);
  }

  /** The mean contact angle of a patch, that of the sum of its strips' forces, drawn in its middle. */
  angle(g, patch, line) {
    const [x, y] = line[Math.floor(line.length / 2)];
    const turn = -(patch.angle * Math.PI) / 180;
    g.strokeStyle = this.look.ink;
    g.lineWidth = 1;
    g.setLineDash([4, 4]);
    for (const a of [0, turn]) {
      g.beginPath();
      g.moveTo(x - 20 * Math.cos(a), y - 20 * Math.sin(a));
      g.lineTo(x + 92 * Math.cos(a), y + 92 * Math.sin(a));
      g.stroke();
    }
    g.setLineDash([]);
    g.beginPath();
    g.arc(x, y, 70, Math.min(0, turn), Math.max(0, turn));
    g.stroke();
    g.textAlign = "left";
    const words = `mean \u03b3 = ${patch.angle.toFixed(1)}\u00b0`.replace("-", "\u2212");
    this.say(g, words, x + 74 * Math.cos(turn / 2) + 6, y + 74 * Math.sin(turn / 2) + 14, 13, this.look.ink);
  }

  /** Forces on the rail at the contacts: N of every patch along its normal, in the whole section Y and Q of the wheel. */
  arrows(g, patches, X, Y, most, near) {
    const largest = Math.max(1e-9, ...patches.map((p) => p.N), Math.abs(this.forces?.Y ?? 0), Math.abs(this.forces?.Q ?? 0));
    const arrow = ([x, y], [dx, dy], colour, words) => {
      const long = Math.hypot(dx, dy);
      if (long < 5) return;
      const [ux, uy] = [dx / long, dy / long], end = [x + dx, y + dy];
      g.strokeStyle = g.fillStyle = colour;
      g.lineWidth = 2;
      g.beginPath();
      g.moveTo(x, y);
      g.lineTo(...end);
      g.stroke();
      g.beginPath();
      g.moveTo(end[0] + 3 * ux, end[1] + 3 * uy);
      g.lineTo(end[0] - 7 * ux - 4 * uy, end[1] - 7 * uy + 4 * ux);
      g.lineTo(end[0] - 7 * ux + 4 * uy, end[1] - 7 * uy - 4 * ux);
      g.fill();
      g.textAlign = ux < -0.3 ? "right" : "left";
      if (words) this.say(g, words, end[0] + 8 * ux + (Math.abs(ux) < 0.3 ? 8 : 0), end[1] + 8 * uy + 4, 12, colour);
    };
    patches.forEach((patch, i) => {
      const [o, b] = patch.points[Math.floor(patch.points.length / 2)];
      const turn = (patch.angle * Math.PI) / 180, long = (most * patch.N) / largest;
      arrow([X(o), Y(b)], [long * Math.sin(turn), long * Math.cos(turn)], this.look.N, near || patches.length === 1 ? `N ${kN(patch.N)}` : "");
      if (i || near || !this.forces) return;
      const { Y: side, Q: down } = this.forces;
      if (Number.isFinite(side)) arrow([X(o), Y(b)], [(most * side) / largest, 0], this.look.Y, `Y ${kN(side)}`);
      if (Number.isFinite(down)) arrow([X(o), Y(b)], [0, (most * down) / largest], this.look.Q, `Q ${kN(down)}`);
    });
  }

  key(g, width, top) {
    const n = this.colours.length, wide = 96 / n;
    this.colours.forEach((c, i) => {
      g.fillStyle = c;
      g.fillRect(width - 106 + i * wide, top + 24, wide + 0.5, 8);
    });
    g.fillStyle = this.look.ink;
    g.font = "11px sans-serif";
    g.textAlign = "right";
    g.fillText(`p to ${this.sections.most.toFixed(0)} MPa`, width - 10, top + 18);
  }
}
