// The viewer of a run: wheels on their rails, and the vehicle on its track, at one place.
import { $, VehiclePage, words } from "./controls.js";
import { History } from "./history.js";
import { download, pngOf, Recording, svgOf, videoKind } from "./save.js";
import { Section } from "./section.js";
import { Stage, Track } from "./scene.js";
import { unpackAll } from "./unpack.js";

const fixed = (v, digits) => v.toFixed(digits).replace(/^-(?=[0.]*$)/, "");
const STEADY = 1e-9;

class Viewer extends VehiclePage {
  async begin() {
    this.data = await unpackAll(JSON.parse($("data").textContent));
    const { run, sections, vehicle, modes } = this.data;
    Object.assign(this, { run, sections, vehicle, modes, at: 0, factor: 1, playing: false, phase: 0 });
    if (sections) this.beginSections();
    if (vehicle && (run || modes)) this.beginStage();
    $("flat").hidden = !sections;
    $("space").hidden = !this.stage;
    document.body.classList.toggle("single", !sections || !this.stage);
    if (run) this.beginHistory();
    this.beginControls();
    this.beginKeys();
    this.beginSaving();
    const resized = () => {
      this.section?.draw();
      this.history?.draw();
      this.stage?.resize();
    };
    new ResizeObserver(resized).observe($("panels"));
    this.stage?.resize();
    this.stage?.view("oblique");
    this.show();
  }

  beginSections() {
    this.section = new Section($("section"), this.sections, this.data.colours);
    this.sections.of.forEach((of, i) => {
      const name = this.sections.wheelsets.length > 1 ? `${this.called(of.wheelset)}, ${of.wheel}` : of.wheel;
      $("wheel").append(new Option(name, i));
    });
    $("wheel").addEventListener("change", () => {
      this.section.wheel = Number($("wheel").value);
      this.show();
    });
  }

  /** Histories of the channels of the chosen wheelset and of the bodies; a click or a drag goes to the place. */
  beginHistory() {
    const { run } = this, canvas = $("history");
    this.history = new History(canvas, run, this.count);
    const named = ({ words: long, unit }) => (unit ? `${long} [${unit}]` : long);
    for (const [key, channel] of Object.entries(run.channels)) {
      if (channel.dims.includes("wheelset")) $("channel").append(new Option(named(channel), key));
    }
    (run.bodies ?? []).forEach((body, b) => {
      for (const [key, channel] of Object.entries(run.channels)) {
        if (channel.dims.includes("body")) $("channel").append(new Option(`${body}: ${named(channel)}`, `${key}|${b}`));
      }
    });
    const keys = [...$("channel").options].map((option) => option.value);
    $("channel").value = keys.includes("Y_over_Q") ? "Y_over_Q" : keys[0];
    $("channel").addEventListener("change", () => this.show());
    const go = (event) => {
      this.play(false);
      this.go(this.history.sampleAt(event.offsetX));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      go(event);
    });
    canvas.addEventListener("pointermove", (event) => event.buttons && go(event));
  }

  showHistory(i) {
    const [key, body] = $("channel").value.split("|");
    Object.assign(this.history, { key, at: i, part: body === undefined ? this.wheelset : Number(body) });
    this.history.draw();
    const { words: long, unit } = this.run.channels[key];
    const told = this.history.lines().map(([name, , value]) => `${name} ${words(value(i))} ${unit}`).join(", ");
    $("history").setAttribute("aria-label", `${long} over ${this.history.label}; here ${told}`);
  }

  /** The number of the wheelset that is looked at. */
  get wheelset() {
    const of = this.sections?.of[this.section.wheel];
    return Math.max(this.run.wheelsets.indexOf(of?.wheelset ?? $("focus").value), 0);
  }

  /** Space plays, arrows move, wherever the keys are not needed for something else. */
  beginKeys() {
    let pointed = false;
    document.addEventListener("pointerdown", () => (pointed = true), true);
    document.addEventListener("keydown", (event) => {
      pointed = false;
      const { target, key } = event;
      const ours = [" ", "ArrowLeft", "ArrowRight"].includes(key); // in a list up and down choose, Enter opens it
      const typed = target.matches?.(ours ? "input:not([type=range])" : "select, input:not([type=range])");
      if (typed || event.ctrlKey || event.altKey || event.metaKey) return;
      if (key === " ") {
        if (target.matches?.("button, summary, a") || $("play").hidden) return;
        this.play(!this.playing);
      } else {
        const far = event.shiftKey ? 10 : 1;
        const to = { ArrowLeft: this.at - far, ArrowRight: this.at + far, Home: 0, End: this.count - 1 }[key];
        if (to === undefined || !this.count || target.id === "size") return;
        this.play(false);
        this.go(Math.round(to));
      }
      event.preventDefault();
    });
    // a list that was chosen from with the mouse gives the keys back
    document.addEventListener("change", ({ target }) => pointed && target.matches("select") && target.blur());
  }

  beginSaving() {
    const painters = { section: this.section, history: this.history };
    const name = (what, ending) => `${this.data.title}_${what}_${$("place-shown").textContent}.${ending}`;
    for (const button of document.querySelectorAll("[data-save]")) {
      const [what, kind] = button.dataset.save.split(".");
      button.addEventListener("click", async () => {
        download(kind === "svg" ? svgOf(painters[what]) : await pngOf($(what)), name(what, kind));
      });
    }
    $("video").hidden = !videoKind() || (!this.run && !this.modes);
    $("video").addEventListener("click", async () => {
      if (this.recording) return this.play(false);
      download(await this.record(), name("video", "webm"));
    });
  }

  /** A video of what is played from here to the end or until it is stopped. */
  record() {
    this.recording = new Recording(["section", "stage", "history"].map($));
    $("video").setAttribute("aria-pressed", "true");
    this.show(); // the first frame has its words
    this.play(true);
    return new Promise((done) => (this.recorded = done));
  }

  beginStage() {
    this.stage = new Stage($("stage"), this.vehicle, new Track(this.run?.track), this.run?.bent);
    if (this.run?.suspension) {
      this.places = this.stage.elements.map((e) => this.run.suspension.names.indexOf(e.name));
    }
  }

  get count() {
    return this.run ? this.run.distance.data.length : this.section?.count ?? 0;
  }

  beginControls() {
    const { run } = this;
    $("title").textContent = document.title = this.data.title;
    for (const note of this.data.notes) $("notes").append(Object.assign(document.createElement("p"), { textContent: note }));
    $("place").max = Math.max(this.count - 1, 0);
    $("place").addEventListener("input", () => this.go(Number($("place").value)));
    $("play").addEventListener("click", () => this.play(!this.playing));
    this.beginCamera();
    for (const event of run?.events ?? []) $("event").append(new Option(`${event.s.toFixed(1)} m: ${event.words}`, event.s));
    $("event").addEventListener("change", () => $("event").value && this.seek(Number($("event").value)));
    $("event-label").hidden = !run?.events.length;
    $("run-controls").hidden = !this.count;
    for (const id of ["play", "rate-label"]) $(id).hidden = !run && !this.modes;
    $("time").hidden = !run;
    $("wear-key").hidden = !this.sections?.of.some((of) => of.wear);
    $("exaggeration").hidden = !this.stage || Boolean(this.modes);
    $("bent-key").hidden = !run?.bent || !this.stage;
    $("forces-key").hidden = !run?.suspension;
    $("mode-controls").hidden = !this.modes;
    if (this.modes) this.beginModes();
    const largest = this.largest();
    if (largest !== null) this.go(largest);
  }

  /** The sample with the largest Y/Q: there is most to see. */
  largest() {
    const channel = this.run?.channels.Y_over_Q;
    if (!channel) return null;
    let best = [-Infinity, 0];
    channel.data.forEach((v, i) => (best = v > best[0] ? [v, i] : best));
    const sample = Math.floor((best[1] / channel.data.length) * this.count);
    const wheel = this.sections?.of.length ? best[1] % this.sections.of.length : 0;
    if (this.section) $("wheel").value = this.section.wheel = wheel;
    return sample;
  }

  beginModes() {
    this.modes.speeds.forEach((of, i) => $("speed").append(new Option(`${of.speed.toFixed(1)} km/h${of.critical ? ", critical" : ""}`, i)));
    const fill = () => {
      const { modes } = this.modes.speeds[$("speed").value];
      const least = modes.reduce((best, m, i) => (m.damping < modes[best].damping ? i : best), 0);
      $("mode").replaceChildren(...modes.map((m, i) => new Option(`${m.frequency.toFixed(2)} Hz, damping ${(100 * m.damping).toFixed(1).replace(/^-0\.0$/, "0.0").replace("-", "\u2212")} %: ${m.name}`, i)));
      $("mode").value = least;
      this.show();
    };
    $("speed").addEventListener("change", fill);
    $("mode").addEventListener("change", () => this.show());
    $("size").addEventListener("input", () => this.show());
    const critical = this.modes.speeds.findIndex((of) => of.critical);
    $("speed").value = Math.max(critical, 0);
    fill();
  }

  /** Show sample i; a broken number stands between two samples and is for motion pictures only. */
  go(i) {
    this.at = Math.min(Math.max(i, 0), this.count - 1);
    this.show();
  }

  value(name, sample, k) {
    const channel = this.run.channels[name];
    if (!channel) return 0;
    const row = channel.data.length / this.count;
    const i = Math.floor(sample), r = sample - i;
    const a = channel.data[i * row + k];
    return (r < STEADY ? a : a * (1 - r) + channel.data[Math.min(i + 1, this.count - 1) * row + k] * r) / channel.factor;
  }

  mixed(array, sample, row = 1, k = 0) {
    const i = Math.floor(sample), r = sample - i;
    const a = array.data[i * row + k];
    return r < STEADY ? a : a * (1 - r) + array.data[Math.min(i + 1, this.count - 1) * row + k] * r;
  }

  show() {
    if (this.stage && this.run) this.placeRun();
    if (this.stage && this.modes) this.placeMode();
    this.stage?.render();
    if (!this.count) return this.recording?.frame(this.data.title);
    const i = Math.round(this.at);
    $("place").value = i;
    const told = this.run ? `${fixed(this.run.distance.data[i], 2)} m, ${this.run.time.data[i].toFixed(3)} s` : this.sections.poses[i];
    $("place-shown").textContent = told;
    if (this.history) this.showHistory(i);
    $("place").setAttribute("aria-valuetext", told);
    if (this.section) this.showSection(i);
    this.showNumbers(i);
    this.recording?.frame(`${this.data.title}: ${told}`);
  }

  showSection(i) {
    const { section, sections, run } = this;
    const of = sections.of[section.wheel];
    section.forces = null;
    if (run) {
      const times = sections.time, now = run.time.data[i];
      let best = 0;
      times.forEach((t, k) => (best = Math.abs(t - now) < Math.abs(times[best] - now) ? k : best));
      section.moment = best;
      const sample = this.sampleAt(times[best]);
      const wheels = sections.wheels.length;
      const k = run.wheelsets.indexOf(of.wheelset) * wheels + sections.wheels.indexOf(of.wheel);
      if (run.channels.Y) section.forces = { Y: this.value("Y", sample, k) * 1e-3, Q: this.value("Q", sample, k) * 1e-3 };
      $("section-place").textContent = `drawn at ${sections.at[best].toFixed(2)} m`;
    } else {
      section.moment = i;
      $("section-place").textContent = sections.poses[i];
    }
    const patches = section.patches();
    const said = patches.map((p) => `N ${words(p.N)} kN, contact angle ${words(p.angle)} degrees, p0 ${words(p.p0)} MPa`).join("; ") || "no contact";
    $("section").setAttribute("aria-label", `${this.called(of.wheelset)}, ${of.wheel} wheel on its rail, ${$("section-place").textContent}: ${said}`);
    section.draw();
  }

  sampleAt(time) {
    const times = this.run.time.data;
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle;
      else high = middle;
    }
    return time - times[low] <= times[high] - time ? low : high;
  }

  placeRun() {
    const { run, vehicle, at } = this;
    const count = run.wheelsets.length, s = this.mixed(run.distance, at);
    const poses = [];
    run.wheelsets.forEach((name, w) => {
      const get = (channel) => this.value(channel, at, w);
      const i = Math.floor(at);
      let spin = run.spin.data[i * count + w];
      if (at > i && i + 1 < this.count) {
        const turn = run.spin.data[(i + 1) * count + w] - spin;
        spin += (at - i) * (turn < -Math.PI ? turn + 2 * Math.PI : turn);
      }
      poses.push([name, { place: this.mixed(run.place, at, count, w), lateral: get("lateral_shift"), vertical: get("vertical_shift"), yaw: get("yaw"), roll: get("roll"), spin }]);
    });
    (run.bodies ?? []).forEach((name, b) => {
      const centre = vehicle.bodies.find((body) => body.name === name)?.centre ?? [0, 0, 0];
      const get = (channel) => this.value(channel, at, b);
      poses.push([name, { place: s + centre[0] - vehicle.reference, lateral: get("body_lateral"), vertical: get("body_vertical"), yaw: get("body_yaw"), pitch: get("body_pitch"), roll: get("body_roll") }]);
    });
    this.stage.pose(s, poses, this.factor, Math.round(at) === run.bent?.sample);
    if (this.places) {
      const { share, names } = run.suspension;
      this.stage.colour(this.places.map((k) => (k < 0 ? 0 : this.mixed(share, at, names.length, k) / 250)));
    }
  }

  placeMode() {
    const of = this.modes.speeds[$("speed").value], mode = of?.modes[$("mode").value];
    if (!mode) return;
    const c = Math.cos(this.phase), d = Math.sin(this.phase);
    const half = new Map(this.vehicle.bodies.map((b) => [b.name, b.size]));
    // the largest motion of any corner becomes the chosen size
    const reach = Math.max(...mode.real.map((row, b) => {
      const size = half.get(this.modes.bodies[b]) ?? [1, 1.5, 1];
      const [z, x, y, yaw, roll, pitch] = row.map((v, k) => Math.hypot(v, mode.imag[b][k]));
      const spins = half.has(this.modes.bodies[b]) ? pitch : 0;
      return Math.max(y + (yaw * size[0]) / 2 + (roll * size[2]) / 2, z + (spins * size[0]) / 2 + (roll * size[1]) / 2, x);
    }), 1e-12);
    const scale = Number($("size").value) / reach;
    const poses = this.modes.bodies.map((name, b) => {
      const [vertical, ahead, lateral, yaw, roll, pitch] = mode.real[b].map((v, k) => scale * (v * c - mode.imag[b][k] * d));
      const part = this.stage.parts.get(name), turns = Boolean(part?.turning);
      return [name, { place: (part?.centre[0] ?? 0) - this.vehicle.reference, ahead, lateral, vertical, yaw, roll, pitch: turns ? 0 : pitch, spin: 0 }];
    });
    this.stage.pose(0, poses, 1);
  }

  showNumbers(i) {
    if (!this.run) return;
    const { run, wheelset: w } = this;
    const found = this.read(i).wheelsets[run.wheelsets[w]];
    const rows = Object.entries(found).map(([name, value]) => {
      const { unit, words: long } = run.channels[name];
      const cells = typeof value === "object" ? Object.values(value) : [value, null];
      return [unit ? `${long} [${unit}]` : long, ...cells];
    });
    $("numbers-name").textContent = this.called(run.wheelsets[w]);
    $("numbers-body").replaceChildren(...rows.map(([name, ...cells]) => {
      const row = document.createElement("tr");
      row.append(Object.assign(document.createElement("th"), { textContent: name, scope: "row" }));
      cells.forEach((cell) => row.append(Object.assign(document.createElement("td"), { textContent: cell === null ? "" : words(cell) })));
      return row;
    }));
  }

  /** The numbers of the dataset at sample i. */
  read(i) {
    const { run } = this, wheels = this.sections?.wheels ?? ["left", "right"];
    const found = { sample: i, s: run.distance.data[i], time: run.time.data[i], wheelsets: {}, bodies: {} };
    const pick = (channel, k) => channel.data[i * (channel.data.length / this.count) + k];
    run.wheelsets.forEach((name, w) => {
      const own = (found.wheelsets[name] = {});
      for (const [key, channel] of Object.entries(run.channels)) {
        if (!channel.dims.includes("wheelset")) continue;
        own[key] = channel.dims.includes("wheel") ? Object.fromEntries(wheels.map((side, j) => [side, pick(channel, w * wheels.length + j)])) : pick(channel, w);
      }
    });
    (run.bodies ?? []).forEach((name, b) => {
      const own = (found.bodies[name] = {});
      for (const [key, channel] of Object.entries(run.channels)) if (channel.dims.includes("body")) own[key] = pick(channel, b);
    });
    return found;
  }

  /** Go to the sample nearest to a distance [m] (to the pose of that number); returns its numbers. */
  seek(s) {
    this.play(false);
    if (!this.run) {
      this.go(Math.round(s));
      return { pose: this.sections.poses[this.at], section: this.told() };
    }
    const data = this.run.distance.data;
    let best = 0;
    data.forEach((d, i) => (best = Math.abs(d - s) < Math.abs(data[best] - s) ? i : best));
    this.go(best);
    return { ...this.read(best), section: this.told() };
  }

  told() {
    if (!this.section) return null;
    const { moment, wheel } = this.section, of = this.sections.of[wheel];
    return { moment, at: this.sections.at?.[moment] ?? null, time: this.sections.time?.[moment] ?? null, wheelset: of.wheelset, wheel: of.wheel,
      patches: this.section.patches().map(({ N, angle, p0 }) => ({ N, angle, p0 })) };
  }

  play(on) {
    this.playing = on;
    $("play").textContent = on ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", String(on));
    if (!on) {
      this.at = Math.round(this.at);
      if (this.recording) {
        this.recording.end().then(this.recorded);
        this.recording = null;
        $("video").setAttribute("aria-pressed", "false");
      }
      return;
    }
    if (this.run && this.at >= this.count - 1) this.at = 0;
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      const passed = ((now - before) / 1000) * Number($("rate").value);
      before = now;
      if (this.modes) {
        const mode = this.modes.speeds[$("speed").value].modes[$("mode").value];
        this.phase += 2 * Math.PI * passed * mode.frequency;
        this.show();
      } else {
        const i = Math.floor(this.at), times = this.run.time.data;
        const dt = times[Math.min(i + 1, this.count - 1)] - times[Math.max(Math.min(i, this.count - 2), 0)];
        this.go(this.at + passed / Math.max(dt, 1e-6));
        if (this.at >= this.count - 1) this.play(false);
      }
      if (this.playing) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}

const viewer = new Viewer();
window.wrsim = { viewer, ready: viewer.begin().catch((problem) => {
  $("notes").append(Object.assign(document.createElement("p"), { textContent: `The viewer cannot start in this browser: ${problem.message}` }));
  throw problem;
}), seek: (s) => viewer.seek(s) };
