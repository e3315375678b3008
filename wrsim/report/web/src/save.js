// What is saved from the viewer: pictures as PNG and SVG, a video of what is played.
const round = (v) => Math.round(v * 100) / 100;
const escaped = (words) => words.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

/** A drawing context that writes SVG: the part of the two-dimensional context of a canvas that the viewer uses. */
export class Drawing {
  constructor(width, height) {
    Object.assign(this, { width, height, parts: [], stack: [], path: "", dash: [], groups: 0, clips: 0 });
    Object.assign(this, { fillStyle: "#000", strokeStyle: "#000", lineWidth: 1, lineCap: "butt", font: "12px sans-serif", textAlign: "left" });
    this.ruler = document.createElement("canvas").getContext("2d");
  }

  save() {
    const { fillStyle, strokeStyle, lineWidth, lineCap, font, textAlign, dash, groups } = this;
    this.stack.push({ fillStyle, strokeStyle, lineWidth, lineCap, font, textAlign, dash, groups });
    this.groups = 0;
  }

  restore() {
    while (this.groups-- > 0) this.parts.push("</g>");
    Object.assign(this, this.stack.pop());
  }

  beginPath() {
    this.path = "";
  }

  moveTo(x, y) {
    this.path += `M${round(x)} ${round(y)}`;
  }

  lineTo(x, y) {
    this.path += `${this.path ? "L" : "M"}${round(x)} ${round(y)}`;
  }

  closePath() {
    this.path += "Z";
  }

  rect(x, y, width, height) {
    this.path += `M${round(x)} ${round(y)}h${round(width)}v${round(height)}h${round(-width)}Z`;
  }

  arc(x, y, r, from, to) {
    const end = (a) => [x + r * Math.cos(a), y + r * Math.sin(a)];
    this.lineTo(...end(from));
    // two halves: a whole circle has no arc of its own
    for (const a of [(from + to) / 2, to]) this.path += `A${r} ${r} 0 0 ${to > from ? 1 : 0} ${end(a).map(round).join(" ")}`;
  }

  clip() {
    const name = `clip${++this.clips}`;
    this.parts.push(`<clipPath id="${name}"><path d="${this.path}"/></clipPath><g clip-path="url(#${name})">`);
    this.groups += 1;
  }

  paint(what, colour) {
    const [, solid, alpha] = /^(#[0-9a-f]{6})([0-9a-f]{2})$/i.exec(colour) ?? [null, colour, null];
    return `${what}="${solid}"${alpha ? ` ${what}-opacity="${round(parseInt(alpha, 16) / 255)}"` : ""}`;
  }

  get stroked() {
    const dash = this.dash.length ? ` stroke-dasharray="${this.dash.join(" ")}"` : "";
    return `fill="none" ${this.paint("stroke", this.strokeStyle)} stroke-width="${this.lineWidth}" stroke-linecap="${this.lineCap}"${dash}`;
  }

  fill() {
    this.parts.push(`<path d="${this.path}" ${this.paint("fill", this.fillStyle)}/>`);
  }

  stroke() {
    this.parts.push(`<path d="${this.path}" ${this.stroked}/>`);
  }

  box(x, y, width, height, look) {
    this.parts.push(`<rect x="${round(x)}" y="${round(y)}" width="${round(width)}" height="${round(height)}" ${look}/>`);
  }

  fillRect(...box) {
    this.box(...box, this.paint("fill", this.fillStyle));
  }

  strokeRect(...box) {
    this.box(...box, this.stroked);
  }

  write(words, x, y, look) {
    const anchor = { left: "start", center: "middle", right: "end" }[this.textAlign];
    const [size, family] = this.font.split("px ");
    this.parts.push(`<text x="${round(x)}" y="${round(y)}" font-size="${size}" font-family="${family}" text-anchor="${anchor}" ${look}>${escaped(words)}</text>`);
  }

  fillText(words, x, y) {
    this.write(words, x, y, this.paint("fill", this.fillStyle));
  }

  strokeText(words, x, y) {
    this.write(words, x, y, this.stroked);
  }

  measureText(words) {
    this.ruler.font = this.font;
    return this.ruler.measureText(words);
  }

  setLineDash(dash) {
    this.dash = dash;
  }

  /** The drawing as a file. */
  get text() {
    const { width, height } = this;
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">\n${this.parts.join("\n")}\n</svg>\n`;
  }
}

/** SVG of something that paints itself on a context and has a canvas. */
export function svgOf(painter) {
  const { clientWidth: width, clientHeight: height } = painter.canvas;
  const drawing = new Drawing(width, height);
  painter.paint(drawing, width, height);
  return new Blob([drawing.text], { type: "image/svg+xml" });
}

export const pngOf = (canvas) => new Promise((done) => canvas.toBlob(done, "image/png"));

/** Hand a file to the user. */
export function download(content, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name.replace(/[^\w.+-]+/g, "_");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const KINDS = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];
export const videoKind = () => (typeof MediaRecorder === "undefined" ? null : KINDS.find((kind) => MediaRecorder.isTypeSupported(kind)) ?? null);

/** A video of some canvases, as they lie in the page, with a line of words above them. */
export class Recording {
  constructor(canvases) {
    this.canvases = canvases.filter((canvas) => canvas.clientWidth && canvas.clientHeight);
    const boxes = this.canvases.map((canvas) => canvas.getBoundingClientRect());
    this.left = Math.min(...boxes.map((b) => b.left));
    this.top = Math.min(...boxes.map((b) => b.top)) - 28;
    this.boxes = boxes;
    this.film = document.createElement("canvas");
    // even numbers: coders of video ask for them
    this.film.width = 2 * Math.ceil((Math.max(...boxes.map((b) => b.right)) - this.left) / 2);
    this.film.height = 2 * Math.ceil((Math.max(...boxes.map((b) => b.bottom)) - this.top) / 2);
    this.parts = [];
    this.frame("");
    this.recorder = new MediaRecorder(this.film.captureStream(30), { mimeType: videoKind(), videoBitsPerSecond: 6e6 });
    this.recorder.ondataavailable = (event) => this.parts.push(event.data);
    this.recorder.start(500);
  }

  frame(words) {
    const g = this.film.getContext("2d");
    g.fillStyle = "#fff";
    g.fillRect(0, 0, this.film.width, this.film.height);
    g.fillStyle = "#222";
    g.font = "15px sans-serif";
    g.fillText(words, 8, 19);
    this.canvases.forEach((canvas, k) => {
      const { left, top, width, height } = this.boxes[k];
      g.drawImage(canvas, left - this.left, top - this.top, width, height);
    });
  }

  end() {
    return new Promise((done) => {
      this.recorder.onstop = () => done(new Blob(this.parts, { type: "video/webm" }));
      this.recorder.stop();
    });
  }
}
