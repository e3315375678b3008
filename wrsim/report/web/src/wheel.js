// One wheel on one rail in the program: what wrsim_contact.h has, and the pose of a wheel in somebody's hand.
import { Struct } from "./live.js";

const MOST = { patches: 8, strips: 400, cells: 20000 };
const RESULT = new Struct([..."Ft Fo Fb Mt Mo Mb wear closest".split(" ").map((name) => [name, "f"]), ["patches", "i"], ["status", "i"]]);

/** The pose of a wheel: origin, axle, velocity, omega in the axes of its rail (12 numbers).
 *
 * shift: outward from its place at nominal gauge [m]; height: of the tape circle above the rail's origin [m]; yaw, roll
 * about the wheel's own origin [rad]; xi: by how much slower it turns than rolling at the tape circle would [1]; eta:
 * lateral velocity over the speed [1]; phi: turning about the vertical over the speed [rad/m]. */
export function poseOf({ place, radius, speed }, { shift, height, yaw, roll, xi, eta, phi }) {
  const [sa, ca, sb, cb] = [Math.sin(yaw), Math.cos(yaw), Math.sin(roll), Math.cos(roll)];
  const axle = [-sa * cb, ca * cb, sb], turning = (speed / radius) * (1 - xi);
  const omega = axle.map((e) => turning * e);
  omega[2] += phi * speed;
  return [0, place + shift, radius + height, ...axle, speed, eta * speed, 0, ...omega];
}

/** The outline (o, b) of a wheel seen along its rail (contact/search/locus.py), for drawing; points: [u, radius] [m]. */
export function outlineOf(points, pose) {
  const [o, b, x, y, z] = [pose[1], pose[2], pose[3], pose[4], pose[5]], q = Math.sqrt(1 - x * x);
  return points.map(([u, rho], i) => {
    const [before, after] = [points[Math.max(i - 1, 0)], points[Math.min(i + 1, points.length - 1)]];
    const [du, dw] = [after[0] - before[0], before[1] - after[1]], long = Math.hypot(du, dw);
    // where the flange is steeper than the line of sight the largest circle hides the rest up to the axle
    const sine = Math.min(Math.max(((-dw / long) * x) / (Math.max(du / long, 1e-3) * q), -1), 1);
    const cosine = Math.sqrt(1 - sine * sine);
    return [o + u * y + (rho * (cosine * z - sine * x * y)) / q, b + u * z + (rho * (-cosine * y - sine * x * z)) / q];
  });
}

export class Wheel {
  /** segments: of the file that ContactModel.library_file makes; layout: fields of patches and strips. */
  constructor(program, segments, layout) {
    const size = segments.reduce((sum, part) => sum + part.length, 0), bytes = new Uint8Array(size);
    segments.reduce((at, part) => (bytes.set(part, at), at + part.length), 0);
    Object.assign(this, { program, call: program.call, patch: new Struct(layout.patch), strip: new Struct(layout.strip) });
    const at = program.keep(bytes), slot = program.room(4), message = program.room(400);
    const status = this.call.wrsim_contact_open_memory(at, size, slot, message, 400);
    const why = status ? program.text(message) : "";
    this.handle = program.view.getUint32(slot, true);
    for (const done of [at, slot, message]) this.call.free(done);
    if (status) throw new Error(why);
    this.pose = program.room(96);
    this.rows = program.room(Math.max(RESULT.size, MOST.patches * this.patch.size, MOST.strips * this.strip.size, MOST.cells * 8));
  }

  set friction(value) {
    this.call.wrsim_contact_set_friction(this.handle, value);
  }

  /** The contact at a pose (12 numbers), or, with a load [N], at the height that carries it: all numbers in SI units. */
  contact(pose, load) {
    const { program, call, handle } = this, at = this.pose;
    program.doubles(at, 12).set(pose);
    const vectors = [at, at + 24, at + 48, at + 72];
    const follows = Number(load !== undefined); // the first guess of a search alone: what it ends with is cold
    if (follows !== this.follows) call.wrsim_contact_follow(handle, (this.follows = follows));
    const status = load === undefined ? call.wrsim_contact_evaluate(handle, ...vectors, 0) : call.wrsim_contact_solve(handle, load, ...vectors, 0);
    const solved = [...program.doubles(at, 12)];
    if (status < 0) return { status, pose: solved, words: this.words(status), patches: [] };
    call.wrsim_contact_forces(handle, this.rows);
    const total = RESULT.read(program.view, this.rows);
    const count = call.wrsim_contact_patches(handle, this.rows, MOST.patches);
    const patches = this.read(this.patch, count);
    patches.forEach((patch, i) => {
      patch.rows = this.read(this.strip, call.wrsim_contact_strips(handle, i, this.rows, MOST.strips));
      const cells = call.wrsim_contact_tractions(handle, i, this.rows, MOST.cells);
      patch.cells = cells > 0 ? program.doubles(this.rows, cells).slice() : null;
    });
    return { ...total, status, pose: solved, words: this.words(status), patches };
  }

  read(struct, count) {
    const { view } = this.program;
    return Array.from({ length: count }, (_, i) => struct.read(view, this.rows + i * struct.size));
  }

  words(status) {
    const length = this.call.wrsim_contact_words(status, this.rows, 1000);
    return length ? this.program.text(this.rows) : "";
  }

  free() {
    this.call.wrsim_contact_free(this.handle);
    this.call.free(this.pose);
    this.call.free(this.rows);
  }
}
