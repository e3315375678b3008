// The vehicle's program in a thread of its own: it moves on at the wanted speed and sends what the page shows.
const SLICE = 12, FRAME = 16; // longest work without listening, least time between two frames [ms]
const EVERY = 10e-3; // between two samples of the histories [s]
const PIECE = 4; // numbers of a piece of the motion: time, distance, speed, acceleration
const RATE_OF_SPEED = 1; // at which the speed changes [m/s2]
const NEVER = 1e30;
const LOST = 20; // steps one after another that leave more than the weight without balance

/** A vehicle: the functions of its unit, and its workspace as numbers. */
class Unit {
  constructor(exports, token, places) {
    Object.assign(this, { exports, places, changed: new Map(), step: places.step, steps: 0, ramp: null });
    const words = new TextEncoder().encode(`${token}\0`), at = exports.malloc(words.length);
    new Uint8Array(exports.memory.buffer).set(words, at);
    this.instance = exports.fmi3InstantiateCoSimulation(at, at, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0);
    if (!this.instance) throw new Error("there is not enough memory");
    this.begin();
  }

  /** The workspace; memory that grows is another one. */
  get numbers() {
    return new Float64Array(this.exports.memory.buffer, this.exports.wrsim_numbers(this.instance), this.places.count);
  }

  whole(place) {
    return Number(new BigInt64Array(this.exports.memory.buffer, this.exports.wrsim_numbers(this.instance) + 8 * place, 1)[0]);
  }

  begin() {
    this.exports.fmi3Reset(this.instance);
    Object.assign(this, { steps: 0, ramp: null, lost: 0 });
    const { numbers } = this;
    for (const [place, value] of this.changed) numbers[place] = value;
    this.exports.fmi3EnterInitializationMode(this.instance, 0, 0, 0, 0, 0);
    this.exports.fmi3ExitInitializationMode(this.instance);
  }

  get time() {
    return this.steps * this.step;
  }

  set(pairs) {
    const { numbers } = this;
    for (const [place, value] of pairs) {
      this.changed.set(place, value);
      numbers[place] = value;
    }
  }

  /** Distance and speed of the run's motion now. */
  motion() {
    const { first, pieces } = this.places.speed, { numbers, time } = this;
    let at = first;
    for (let k = 1; k < pieces && numbers[first + k * PIECE] <= time; k++) at = first + k * PIECE;
    const [begun, distance, speed, rate] = numbers.subarray(at, at + PIECE), since = time - begun;
    return [distance + since * (speed + 0.5 * rate * since), speed + rate * since];
  }

  piece(distance, speed, rate) {
    const { first, pieces } = this.places.speed, { numbers } = this;
    numbers.set([this.time, distance, speed, rate], first);
    for (let k = 1; k < pieces; k++) numbers.set([k * NEVER, 0, 0, 0], first + k * PIECE);
  }

  /** From now on the speed goes to this one, evenly. */
  goTo(speed) {
    const [distance, now] = this.motion();
    this.piece(distance, now, Math.sign(speed - now) * RATE_OF_SPEED);
    this.ramp = { speed, end: this.time + Math.abs(speed - now) / RATE_OF_SPEED };
  }

  /** One step; why the run has ended, if it has. */
  advance() {
    if (this.ramp && this.time >= this.ramp.end) {
      this.piece(this.motion()[0], this.ramp.speed, 0);
      this.ramp = null;
    }
    if (this.exports.fmi3DoStep(this.instance, this.time, this.step, 0, 0, 0, 0, 0)) return "the vehicle has left its track, or a force is not a number";
    this.steps += 1;
    const { residual, weight } = this.places;
    this.lost = this.numbers[residual] > weight ? this.lost + 1 : 0;
    return this.lost < LOST ? "" : `the integration diverges: ${LOST} steps in turn left more than the weight without balance`;
  }

  copy(first, count) {
    return this.numbers.slice(first, first + count);
  }

  /** What the page draws now; wheel: the one whose patches are shown. */
  frame(wheel) {
    const { coordinates, bodies, forces, wheels, residual, weight, records } = this.places, of = wheels[wheel];
    const lobes = this.whole(of.lobes), strips = records.strip * of.most;
    return {
      time: this.time, speed: this.motion()[1], residual: this.numbers[residual] / weight,
      q: this.copy(coordinates, 6 * bodies.count), bodies: this.copy(bodies.first, bodies.count * bodies.names.length),
      forces: this.copy(forces.first, wheels.length * forces.names.length),
      wheel, pose: this.copy(of.pose, 12), lobes, status: this.whole(of.status),
      patches: this.copy(of.patches, lobes * records.lobe), strips: this.copy(of.strips, lobes * strips),
      counts: Array.from({ length: lobes }, (_, i) => this.whole(of.patches + i * records.lobe + records.strips_of_lobe)),
    };
  }

  /** A row of the histories: time, motions of all bodies, forces of all wheels. */
  sample() {
    const { bodies, forces, wheels } = this.places;
    return [this.time, ...this.copy(bodies.first, bodies.count * bodies.names.length), ...this.copy(forces.first, wheels.length * forces.names.length)];
  }
}

let unit, end, playing = false, rate = 1, wheel = 0, due = 0, before = 0, shown = 0, samples = [], busy = 0, spent = 0;

function send(more = {}) {
  const frame = unit.frame(wheel);
  postMessage({ frame, samples, cost: spent ? busy / spent : 0, memory: unit.exports.memory.buffer.byteLength, ...more });
  samples = [];
}

function restart(reason) {
  unit.begin();
  samples = [unit.sample()];
  due = 0;
  send({ restarted: reason });
}

/** Some steps; why the run has ended, if it has. */
function move(count) {
  const every = Math.max(Math.round(EVERY / unit.step), 1);
  for (let i = 0; i < count; i++) {
    const ended = unit.advance();
    if (ended) return ended;
    if (unit.steps % every === 0) samples.push(unit.sample());
  }
  return "";
}

function work() {
  const now = performance.now();
  if (playing) {
    due = Math.min(due + ((now - before) / 1000) * rate, 0.1 * rate + unit.step);
    let steps = 0, ended = "";
    while (!ended && due >= unit.step && performance.now() - now < SLICE) {
      ended = move(1);
      due -= unit.step;
      steps += 1;
    }
    const took = performance.now() - now;
    if (steps) [busy, spent] = [0.95 * busy + took, 0.95 * spent + steps * unit.step * 1e3];
    if (ended) {
      playing = false;
      send({ ended });
    } else if (unit.numbers[unit.places.bodies.first] > end) restart("the end of the track");
    else if (now - shown > FRAME) {
      shown = now;
      send();
    }
  }
  before = now;
  if (playing) next.port2.postMessage(0);
  else setTimeout(work, 30);
}

const next = new MessageChannel(); // messages wait their turn behind those of the page; a timer waits 4 ms
next.port1.onmessage = work;

onmessage = async ({ data }) => {
  if (data.program) {
    const { instance } = await WebAssembly.instantiate(data.program, {});
    instance.exports._initialize?.();
    unit = new Unit(instance.exports, data.token, data.places);
    wheel = data.wheel;
    before = performance.now();
    samples = [unit.sample()];
    send({ begun: true });
    work();
  } else if (data.set) unit.set(data.set);
  else if (data.speed !== undefined) unit.goTo(data.speed);
  else if (data.restart) restart("");
  else if (data.steps) {
    const ended = move(data.steps);
    send(ended ? { ended } : { moved: data.steps });
  }
  if (data.end) end = data.end;
  if (data.playing !== undefined) playing = data.playing;
  if (data.rate) rate = data.rate;
  if (data.wheel !== undefined) {
    wheel = data.wheel;
    send();
  }
};
