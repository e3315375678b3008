// What live pages share: the program, its memory, the loop of frames, the ground, what is recorded.
import { DARK, LIGHT } from "./canvas.js";
import { download } from "./save.js";

const SIZES = { f: 8, i: 4 };

/** Fields [name, "f" or "i"] of a struct in C: numbers of 8 bytes, and integers of 4 behind them. */
export class Struct {
  constructor(fields) {
    let size = 0;
    this.fields = fields.map(([name, kind]) => [name, kind, (size += SIZES[kind]) - SIZES[kind]]);
    this.size = Math.ceil(size / 8) * 8;
  }

  read(view, at) {
    const read = ([name, kind, offset]) => [name, kind === "f" ? view.getFloat64(at + offset, true) : view.getInt32(at + offset, true)];
    return Object.fromEntries(this.fields.map(read));
  }
}

/** A library in WebAssembly that asks nothing of its host. */
export class Program {
  static async load(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    instance.exports._initialize?.();
    return new Program(instance.exports);
  }

  constructor(functions) {
    this.call = functions;
  }

  /** The memory; a view is of no use any more once the program has taken more of it. */
  get view() {
    return new DataView(this.call.memory.buffer);
  }

  doubles(at, count) {
    return new Float64Array(this.call.memory.buffer, at, count);
  }

  room(size) {
    const at = this.call.malloc(size);
    if (!at) throw new Error("there is not enough memory");
    return at;
  }

  /** Room for these bytes, with them in it. */
  keep(bytes) {
    const at = this.room(bytes.length);
    new Uint8Array(this.call.memory.buffer, at, bytes.length).set(bytes);
    return at;
  }

  text(at) {
    const bytes = new Uint8Array(this.call.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }
}

/** Calls `frame` before the next picture, once however often it is asked; `times` has what the last ones took [ms]. */
export class Loop {
  constructor(frame) {
    Object.assign(this, { frame, times: [], asked: 0 });
  }

  ask() {
    this.asked ||= requestAnimationFrame(() => this.now());
  }

  now() {
    cancelAnimationFrame(this.asked);
    this.asked = 0;
    const begin = performance.now();
    this.frame();
    this.times.push(performance.now() - begin);
    if (this.times.length > 1000) this.times.shift();
  }
}

/** The colours of drawings on the ground that the reader's system has; calls `changed` with others. */
export function ground(changed) {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const look = () => (dark.matches ? DARK : LIGHT);
  dark.addEventListener("change", () => changed(look()));
  return look();
}

/** Rows of numbers by their names, for a file; the oldest go where there are too many. */
export class Record {
  constructor(most = 20000) {
    Object.assign(this, { most, rows: [] });
  }

  add(row) {
    this.rows.push(row);
    if (this.rows.length > this.most) this.rows.splice(0, this.most / 10);
  }

  get text() {
    const names = Object.keys(this.rows[0] ?? {});
    const cell = (value) => (typeof value === "string" ? `"${value.replaceAll('"', '""')}"` : Number.isFinite(value) ? String(value) : "");
    return [names.join(","), ...this.rows.map((row) => names.map((name) => cell(row[name])).join(","))].join("\r\n") + "\r\n";
  }

  save(name) {
    download(new Blob([this.text], { type: "text/csv" }), name);
  }
}

/** A slider with its number beside it: {id, words, unit, least, most, step}; `changed` is called with its value. */
export function slider(parent, { id, words, title, unit, least, most, step }, changed) {
  const label = document.createElement("label");
  label.title = title;
  const range = Object.assign(document.createElement("input"), { type: "range", id, min: least, max: most, step });
  const number = Object.assign(document.createElement("input"), { type: "number", min: least, max: most, step, ariaLabel: `${words} in ${unit || "1"}` });
  const set = (value) => {
    range.value = value;
    number.value = Number(Number(value).toFixed(4));
    range.setAttribute("aria-valuetext", `${number.value} ${unit}`);
  };
  const take = (from) => () => {
    if (from.value === "" || !Number.isFinite(from.valueAsNumber)) return;
    changed(Math.min(Math.max(from.valueAsNumber, least), most));
  };
  range.addEventListener("input", take(range));
  number.addEventListener("change", take(number));
  label.append(Object.assign(document.createElement("span"), { textContent: unit ? `${words} [${unit}]` : words }), range, number);
  parent.append(label);
  return { set, label };
}
