// The vehicle on its swept track. The origin of the scene travels with the vehicle: it is the track frame at the
// vehicle's place, so that numbers stay small however long the line is (positions are doubles until then).
import {
  AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, CatmullRomCurve3, Color, CylinderGeometry, DirectionalLight, DoubleSide,
  EdgesGeometry, Group, InstancedMesh, LatheGeometry, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, Object3D, PerspectiveCamera, PlaneGeometry, Scene, SphereGeometry, TubeGeometry, Vector2, Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const BEHIND = 60, AHEAD = 110, STEP = 1, BENT_STEP = 0.25, SLEEPERS = 0.65;
const FORCE = [new Color("#3b6fb6"), new Color("#e8d34a"), new Color("#c01020")];
const SIDES = [1, -1];

/** The centre line at even steps; a straight one without numbers. */
export class Track {
  constructor(track) {
    this.track = track;
  }

  at(s) {
    if (!this.track) return { x: s, y: 0, z: 0, heading: 0, roll: 0, slope: 0 };
    const { start, step, line } = this.track;
    const rows = line.shape[0], wide = line.shape[1], data = line.data;
    const f = Math.min(Math.max((s - start) / step, 0), rows - 1.000001), i = Math.floor(f), r = f - i;
    const mix = (k) => data[i * wide + k] * (1 - r) + data[(i + 1) * wide + k] * r;
    const beyond = s - (start + f * step), heading = mix(3);
    return {
      x: mix(0) + beyond * Math.cos(heading),
      y: mix(1) + beyond * Math.sin(heading),
      z: mix(2),
      heading,
      roll: mix(4),
      slope: (data[(i + 1) * wide + 2] - data[i * wide + 2]) / step,
    };
  }
}

/** A value between numbers that stand at rising places; 0 beyond them. */
function between(places, values, s) {
  let low = 0, high = places.length - 1;
  if (!(s > places[low] && s < places[high])) return 0;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (places[middle] <= s) low = middle;
    else high = middle;
  }
  return values[low] + ((values[high] - values[low]) * (s - places[low])) / (places[high] - places[low]);
}

function material(colour, more = {}) {
  return new MeshLambertMaterial({ color: colour, side: DoubleSide, ...more });
}

/** A wheel turned from its profile about its axle, with disc and hub; outward is +y of the left wheel. */
function wheel(shape, side) {
  const rim = shape.radius - 0.075, last = shape.u.length - 1;
  const profile = shape.u.map((u, i) => [shape.r[i], u]);
  if (shape.u[0] > shape.u[last]) profile.reverse();
  const [inner, outer] = [profile[0][1], profile.at(-1)[1]];
  const points = [
    [0.1, -0.09], [0.13, -0.03], [rim, -0.012], [rim, inner], ...profile, [rim, outer], [rim, 0.012], [0.13, 0.06], [0.1, 0.09],
  ];
  const geometry = new LatheGeometry(points.map(([r, u]) => new Vector2(Math.max(r, 0.001), side * u)), 72);
  const group = new Group();
  group.add(new Mesh(geometry, material("#8b939c", { flatShading: false })));
  // marks on the disc, so that one sees it turn
  for (let k = 0; k < 4; k++) {
    const hole = new Mesh(new CylinderGeometry(0.05, 0.05, 0.11, 16), material(k ? "#4a4f55" : "#d55e00"));
    hole.position.set(0.27 * Math.cos((k * Math.PI) / 2), 0, 0.27 * Math.sin((k * Math.PI) / 2));
    group.add(hole);
  }
  return group;
}

export class Stage {
  /** bent: shapes of rails and axles at one instant, if there are any. */
  constructor(canvas, vehicle, track, bent) {
    Object.assign(this, { canvas, vehicle, track, bent, focus: null, step: bent ? BENT_STEP : STEP });
    const places = vehicle.wheelsets.map((w) => w.x - vehicle.reference);
    this.ends = [Math.min(...places), Math.max(...places)];
    this.behind = BEHIND - Math.min(this.ends[0], -10); // rails beneath the last vehicle of a train too
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.scene = new Scene();
    this.scene.background = new Color("#eef3f8");
    this.camera = new PerspectiveCamera(40, 1, 0.05, 600);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.render());
    this.scene.add(new AmbientLight(0xffffff, 1.5));
    for (const [x, y, z, power] of [[-20, 30, 50, 1.8], [30, -20, 20, 0.6]]) {
      const light = new DirectionalLight(0xffffff, power);
      light.position.set(x, y, z);
      this.scene.add(light);
    }
    this.parts = new Map();
    this.frames = new Group();
    this.scene.add(this.frames);
    this.build();
    this.view("oblique");
  }

  build() {
    const { vehicle } = this;
    for (const set of vehicle.wheelsets) {
      const group = new Group(), turning = new Group();
      set.sides.forEach((shape, j) => {
        const one = wheel(shape, SIDES[j]);
        one.position.y = SIDES[j] * set.spacing / 2;
        turning.add(one);
      });
      const axle = new Mesh(new CylinderGeometry(0.08, 0.08, set.spacing, 20), material("#6d747c"));
      turning.add(axle);
      group.add(turning);
      this.add(set.name, group, [set.x, 0, set.height]);
      Object.assign(this.parts.get(set.name), { turning, axle });
    }
    const largest = Math.max(0, ...vehicle.bodies.map((b) => b.size[0] * b.size[1] * b.size[2]));
    for (const body of vehicle.bodies) {
      const group = new Group(), box = new BoxGeometry(...body.size);
      const main = body.size[0] * body.size[1] * body.size[2] > 0.5 * largest;
      const look = { transparent: true, opacity: main ? 0.22 : 0.55, depthWrite: !main };
      group.add(new Mesh(box, material(main ? "#5b8fc7" : "#c79b3b", look)));
      group.add(new LineSegments(new EdgesGeometry(box), new LineBasicMaterial({ color: "#3b4a5a" })));
      this.add(body.name, group, body.centre);
    }
    this.elements = vehicle.elements.map((element) => {
      const ends = [element.first, element.second].map((name, k) => this.holder(name, element.ends[k]));
      const long = Math.hypot(...element.ends[0].map((v, k) => v - element.ends[1][k])) > 0.04;
      const shape = long ? new CylinderGeometry(0.028, 0.028, 1, 10) : new SphereGeometry(0.055, 14, 10);
      const mesh = new Mesh(shape, new MeshBasicMaterial({ color: FORCE[0], depthTest: false, transparent: true }));
      mesh.renderOrder = 5; // seen through the bodies
      this.scene.add(mesh);
      return { ...element, holders: ends, long, mesh };
    });
    this.rails = SIDES.map((side, j) => this.rail(side, vehicle.rails[j], vehicle.rail_origins[j]));
    const count = Math.floor((this.behind + AHEAD) / SLEEPERS);
    this.sleepers = new InstancedMesh(new BoxGeometry(0.24, 2.5, 0.16), material("#a8a29a"), count);
    this.sleepers.frustumCulled = false;
    this.scene.add(this.sleepers);
    const ground = new Mesh(new PlaneGeometry(1200, 1200), new MeshBasicMaterial({ color: "#d9dfd2" }));
    ground.position.z = -0.75;
    this.ground = ground;
    this.scene.add(ground);
  }

  add(name, group, centre) {
    const carrier = new Group();
    carrier.add(group);
    this.scene.add(carrier);
    group.rotation.order = "ZXY";
    carrier.rotation.order = "ZYX";
    this.parts.set(name, { carrier, group, centre });
  }

  /** Where an end of an element is fixed: a part, and the place in its axes; the track's frame for all else. */
  holder(name, point) {
    const part = this.parts.get(this.vehicle.boxes[name] ?? name);
    const centre = part ? part.centre : [0, 0, 0];
    return { part, local: new Vector3(...point.map((v, k) => v - centre[k])) };
  }

  rail(side, profile, [o, b]) {
    const nodes = Math.floor((this.behind + AHEAD) / this.step) + 1;
    const w = profile.u.map((u, i) => [side * (o + u), b + profile.w[i]]);
    // web and foot, which no contact sees
    const low = Math.min(...profile.w) + b, mid = side * o;
    const ring = [...w, [mid + side * 0.01, low - 0.02], [mid + side * 0.01, b - 0.14], [mid + side * 0.07, b - 0.16],
      [mid - side * 0.07, b - 0.16], [mid - side * 0.01, b - 0.14], [mid - side * 0.01, low - 0.02], w[0]];
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(nodes * ring.length * 3), 3));
    const index = [];
    for (let i = 0; i + 1 < nodes; i++)
      for (let k = 0; k + 1 < ring.length; k++) {
        const a = i * ring.length + k, c = a + ring.length;
        index.push(a, c, a + 1, a + 1, c, c + 1);
      }
    geometry.setIndex(index);
    const mesh = new Mesh(geometry, material("#9aa0a6", { flatShading: true }));
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    return { mesh, ring, nodes };
  }

  /** A place of the track seen from the origin of the scene. */
  relative(s) {
    const p = this.track.at(s), c = Math.cos(this.origin.heading), d = Math.sin(this.origin.heading);
    const dx = p.x - this.origin.x, dy = p.y - this.origin.y;
    return { x: c * dx + d * dy, y: c * dy - d * dx, z: p.z - this.origin.z, heading: p.heading - this.origin.heading, roll: p.roll, slope: p.slope };
  }

  /**
   * Put everything where it is. s: place of the vehicle; poses: by name, each with its place on the track, shifts (to
   * the left, up) and angles against the track frame; factor: by which all of these are exaggerated; isBent: whether
   * rails and axles are bent, by the same factor.
   */
  pose(s, poses, factor, isBent = false) {
    this.origin = this.track.at(s);
    for (const [name, pose] of poses) {
      const part = this.parts.get(name);
      if (!part) continue;
      const frame = this.relative(pose.place);
      part.carrier.position.set(frame.x, frame.y, frame.z);
      part.carrier.rotation.set(frame.roll, -Math.atan(frame.slope), frame.heading);
      part.group.position.set(factor * (pose.ahead ?? 0), part.centre[1] + factor * pose.lateral, part.centre[2] + factor * pose.vertical);
      part.group.rotation.set(factor * pose.roll, factor * (pose.pitch ?? 0), factor * pose.yaw);
      if (part.turning) part.turning.rotation.y = pose.spin ?? 0;
    }
    this.scene.updateMatrixWorld(true);
    const v = new Vector3(), u = new Vector3();
    for (const element of this.elements) {
      element.holders.forEach(({ part, local }, k) => {
        const end = k ? u : v;
        end.copy(local);
        if (part) part.group.localToWorld(end);
        else {
          const f = this.relative(s + local.x - this.vehicle.reference);
          end.set(f.x, f.y + local.y, f.z + local.z);
        }
      });
      const { mesh } = element;
      mesh.position.addVectors(v, u).multiplyScalar(0.5);
      if (element.long) {
        const long = v.distanceTo(u);
        mesh.scale.set(1, Math.max(long, 1e-3), 1);
        mesh.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), u.clone().sub(v).normalize());
      }
    }
    const swept = `${s} ${isBent && factor}`;
    if (this.swept !== swept) {
      this.sweep(s, isBent ? factor : 0);
      this.bend(isBent ? factor : 0);
    }
    this.swept = swept;
    if (this.focus) this.follow();
  }

  /** Elastic axles so many times as bent as they are; straight ones for 0. */
  bend(factor) {
    const { axles, wheelsets } = this.bent ?? {};
    wheelsets?.forEach((name, w) => {
      const part = this.parts.get(name), count = axles?.shape[2] ?? 0;
      const row = (k) => axles.data.subarray((w * 3 + k) * count, (w * 3 + k + 1) * count);
      if (!part || !count || !Number.isFinite(row(0)[0])) return;
      part.bent?.removeFromParent();
      part.axle.visible = !factor;
      if (!factor) return;
      const points = Array.from(row(0), (y, i) => new Vector3(factor * row(1)[i], y, factor * row(2)[i]));
      part.bent = new Mesh(new TubeGeometry(new CatmullRomCurve3(points), 60, 0.08, 16), part.axle.material);
      part.group.add(part.bent);
    });
  }

  /** The rails and sleepers around the vehicle; rails so many times as bent as they are. */
  sweep(s, factor) {
    const first = Math.floor((s - this.behind) / this.step) * this.step, { place, rail } = this.bent ?? {};
    this.rails.forEach(({ mesh, ring, nodes }, j) => {
      const position = mesh.geometry.attributes.position;
      const up = rail && factor ? rail.data.subarray(j * place.data.length, (j + 1) * place.data.length) : null;
      let at = 0;
      for (let i = 0; i < nodes; i++) {
        const f = this.relative(first + i * this.step);
        if (up) f.z += factor * between(place.data, up, first + i * this.step);
        const c = Math.cos(f.roll), d = Math.sin(f.roll), ch = Math.cos(f.heading), sh = Math.sin(f.heading);
        for (const [y, z] of ring) {
          const side = c * y - d * z;
          position.array[at++] = f.x - sh * side;
          position.array[at++] = f.y + ch * side;
          position.array[at++] = f.z + d * y + c * z;
        }
      }
      position.needsUpdate = true;
    });
    const one = new Object3D(), begin = Math.floor((s - this.behind) / SLEEPERS);
    one.rotation.order = "ZYX";
    for (let i = 0; i < this.sleepers.count; i++) {
      const f = this.relative((begin + i) * SLEEPERS);
      one.position.set(f.x, f.y, f.z - 0.3);
      one.rotation.set(f.roll, -Math.atan(f.slope), f.heading);
      one.updateMatrix();
      this.sleepers.setMatrixAt(i, one.matrix);
    }
    this.sleepers.instanceMatrix.needsUpdate = true;
  }

  /** Colours of the elements by their forces, each from its least to its largest of the run: shares 0 to 1. */
  colour(shares) {
    this.elements.forEach((element, i) => {
      const share = Math.min(Math.max(shares[i] ?? 0, 0), 1) * 2, low = Math.min(Math.floor(share), 1);
      element.mesh.material.color.copy(FORCE[low]).lerp(FORCE[low + 1], share - low);
    });
  }

  follow() {
    const part = this.parts.get(this.focus);
    if (!part) return;
    const place = part.carrier.position.clone();
    place.z += part.centre[2];
    const by = place.sub(this.controls.target);
    this.controls.target.add(by);
    this.camera.position.add(by);
    this.controls.update();
  }

  /** Look at the vehicle, or at one part of it, from a side. */
  view(name, focus = this.focus) {
    this.focus = focus;
    const [rear, front] = this.ends, middle = 0.5 * (rear + front);
    const near = focus ? 3.4 : Math.max(6, 0.62 * (front - rear) + 7 + 0.3 * Math.max(0, front - rear - 30));
    const wide = Math.max(1, 1.7 / (this.camera.aspect || 1));
    const from = { oblique: [-0.85, 0.8, 0.5], side: [0, 1.25, 0.12], behind: [-1.2, 0.02, 0.22], above: [0, -0.01, 1.5] }[name];
    const at = [focus ? 0 : middle, 0, focus ? 0.4 : 1];
    this.controls.target.set(...at);
    this.camera.position.set(...from.map((v, k) => v * near * wide + at[k]));
    this.controls.update();
    this.follow();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  render() {
    this.renderer.render(this.scene, this.camera);
  }
}
