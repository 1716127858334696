// A talking face in 2D that can turn its head, on a canvas. Written by articula; no dependency.
//
//   const face = new ArticulaPortrait(canvas, json, images);   // images: one for each view
//   face.pose({ yaw: 20, pitch: 5, roll: 0 }, { jawOpen: 0.4, eyeBlinkLeft: 1 });
//   face.play("talk", { audio });                              // audio is an option: the clock
//   face.drive({ faps: { 3: 400, 49: 20000 }, shapes: { eyeBlinkLeft: 1 }, visemes: { aa: 0.5 } });
//
// Further options of the constructor: `background`, a picture or a slide-show, [{ from: 0, picture }, …] in seconds of
// the clip; `scale`, pixels of the canvas in one of the document; `level`, "high", "medium", "low", "veryLow" or "auto";
// and `budget`, the milliseconds that a frame may take before "auto" goes to a coarser level.
//
// Angles are in degrees: yaw towards the figure's left, pitch down, roll counter-clockwise.
"use strict";

/** Facial animation parameters with one direction, whose values are not below 0. */
const ONE_SIDED = new Set([3, 14, 41, 42, 47]);

/** Levels of articulation, the finest first. */
const LEVELS = ["high", "medium", "low", "veryLow"];
/** Motion that is not seen, pixels of the screen. */
const UNSEEN = 0.5;
/** Frames over which times are averaged, and until a level that saved nothing is tried again, at first. */
const JUDGED = 30;
const TRIED_AGAIN = 600;
/** Share of the budget below which there is room for a finer level, and of a time that a coarser one has to save. */
const ROOM = 0.6;
const SAVED = 0.03;

class ArticulaPortrait {
  constructor(canvas, json, images, { background = null, scale = 1, level = "auto", budget = 12 } = {}) {
    const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.json = json;
    this.slides = Array.isArray(background) ? background : background ? [{ from: 0, picture: background }] : [];
    this.seconds = 0;
    this.frames = 0;
    this.scale = scale;
    [canvas.width, canvas.height] = json.size.map((side) => Math.round(side * scale));
    this.triangles = new Uint16Array(bytes(json.triangles));
    this.count = this.triangles.length / 3;
    this.tilts = new Uint8Array(bytes(json.tilts));
    this.depths = new Int8Array(bytes(json.depths ?? btoa("\0".repeat(this.tilts.length))));
    this.coefficients = new Float32Array(bytes(json.grid.coefficients));
    const scaled = (steps, step) => Float32Array.from(steps, (s) => s * step);
    this.rest = json.grid.rest.map((m) => scaled(new Int16Array(bytes(m.steps)), m.scale));
    this.expressions = json.expressions.map((e) => {
      const vertices = new Uint16Array(bytes(e.vertices));
      const steps = new Int8Array(bytes(e.steps));
      const mode = (k) => scaled(steps.subarray(k * vertices.length, (k + 1) * vertices.length), e.scales[k]);
      return { vertices, modes: e.scales.map((_, k) => mode(k)) };
    });
    this.byName = new Map(json.expressions.map((e, i) => [ArticulaPortrait.fold(e.name), i]));
    this.inputs = new Map(Object.entries(json.inputs ?? {}).map(([name, faps]) => [ArticulaPortrait.fold(name), faps]));
    this.intervals = ArticulaPortrait.intervals(json.expressions.map((e) => e.name));
    this.sectors = json.sectors.map((s) => ({ from: s.from, order: new Uint16Array(bytes(s.order)) }));
    this.clips = json.clips.map((c) => ({
      ...c,
      poses: new Int16Array(bytes(c.poses)),
      weights: new Int16Array(bytes(c.weights)),
    }));
    this.neighbours = this.findNeighbours();
    this.views = json.views.map((view, i) => {
      const places = this.places({ yaw: view.yaw, pitch: view.pitch, roll: 0 }, []);
      const areas = Float32Array.from({ length: this.count }, (_, t) => this.area(places, t));
      const pattern = this.context.createPattern(images[i], "no-repeat");
      return { ...view, places, areas, pattern, layers: new Uint8Array(bytes(view.layers)) };
    });
    this.reaches = this.expressions.map((expression) => this.reach(expression));
    this.budget = budget;
    this.level = level;
    const most = (of) => Math.max(...json.views.map((v) => Math.abs(of(v))));
    this.spans = [most((v) => v.yaw), most((v) => v.pitch)];
  }

  /** Names of both spellings (`eyeBlinkLeft`, `eyeBlink_L`) are one. */
  static fold(name) {
    return name.toLowerCase().replace(/_?left$/, "_l").replace(/_?right$/, "_r");
  }

  /**
   * The expressions of facial animation parameters, by the number of the parameter: `fap19_270_540` is what FAP 19
   * adds between 270 and 540 units.
   */
  static intervals(names) {
    const all = new Map();
    names.forEach((name, expression) => {
      const [, fap, from, to] = (/^fap(\d+)_(-?\d+)_(-?\d+)$/.exec(name) ?? []).map(Number);
      if (fap) all.set(fap, [...(all.get(fap) ?? []), { from, to, expression }]);
    });
    for (const [fap, own] of all) {
      for (const part of own) {
        // A single part from 0 is straight on both sides, unless the parameter has one; of several the outermost goes on.
        part.least = own.length === 1 && part.from === 0 && !ONE_SIDED.has(fap) ? -Infinity : 0;
        part.most = own.some(({ from }) => from === part.to) ? 1 : Infinity;
      }
    }
    return all;
  }

  /**
   * Shows a face given by any of: `faps`, values by the numbers of the parameters or a list that begins with FAP 1;
   * `shapes`, weights by the names of blend shapes; `visemes`, weights by PP, FF, …; `head`, angles in degrees. They
   * add up. `plane` turns the picture, as `turnPlane` does, and `level` is set as the property is. Returns the names
   * that nothing of the portrait shows.
   */
  drive({ faps = {}, shapes = {}, visemes = {}, head = {}, plane, level } = {}) {
    if (level) this.level = level;
    const weights = new Array(this.expressions.length).fill(0);
    const values = new Map();
    const missing = [];
    const add = (fap, value) => values.set(fap, (values.get(fap) ?? 0) + value);
    const name = (name, weight) => {
      const key = ArticulaPortrait.fold(name);
      const own = (this.byName.has(key) ? [key] : [`${key}_l`, `${key}_r`]).filter((k) => this.byName.has(k));
      for (const one of own) weights[this.byName.get(one)] += weight;
      if (own.length === 0 && !this.inputs.has(key)) missing.push(name);
      else if (own.length === 0) for (const [fap, value] of this.inputs.get(key)) add(fap, value * weight);
    };
    const each = (list, act) => Object.entries(list ?? {}).forEach(([key, v]) => Number.isFinite(v) && v && act(key, v));
    each(faps, (key, value) => add(Array.isArray(faps) ? Number(key) + 1 : Number(key), value));
    each(shapes, name);
    each(visemes, (viseme, weight) => viseme !== "sil" && name(`viseme_${viseme}`, weight));
    const [pitch, yaw, roll] = [48, 49, 50].map((fap) => values.get(fap) ?? 0);
    const pose = ArticulaPortrait.turned(pitch, yaw, roll);
    each(head, (axis, degrees) => (pose[axis] += degrees));
    for (const [fap, value] of values) {
      const parts = this.intervals.get(fap) ?? [];
      for (const { from, to, expression, least, most } of parts) {
        weights[expression] += Math.min(Math.max((value - from) / (to - from), least), most);
      }
      if (parts.length === 0 && (fap < 48 || fap > 50)) missing.push(`fap${fap}`);
    }
    this.driven = { pose, weights };
    this.draw(pose, weights);
    if (plane) this.turnPlane(plane);
    return missing;
  }

  /** FAP 48 to 50, in units of 1e-5 rad: yaw, then pitch, then roll, each about axes that the one before turned. */
  static turned(...units) {
    const [[sp, cp], [sy, cy], [sr, cr]] = units.map((unit) => [Math.sin(unit * 1e-5), Math.cos(unit * 1e-5)]);
    const degrees = (y, x) => (Math.atan2(y, x) * 180) / Math.PI;
    const up = sy * cr - cy * sp * sr;
    return {
      yaw: degrees(up, Math.sqrt(Math.max(1 - up * up, 0))),
      pitch: degrees(sy * sr + cy * sp * cr, cy * cp),
      roll: degrees(cp * sr, cy * cr + sy * sp * sr),
    };
  }

  /** Shows a pose. Unknown names do nothing; a name without a side drives both. */
  pose({ yaw = 0, pitch = 0, roll = 0 } = {}, weights = {}) {
    const driven = new Array(this.expressions.length).fill(0);
    for (const [name, weight] of Object.entries(weights)) {
      const key = ArticulaPortrait.fold(name);
      const found = this.byName.has(key) ? [key] : [`${key}_l`, `${key}_r`];
      for (const one of found) if (this.byName.has(one)) driven[this.byName.get(one)] = weight;
    }
    this.draw({ yaw, pitch, roll }, driven);
  }

  /** Turns the plane of the picture in space, in degrees as a head turns; nothing is drawn anew. */
  turnPlane({ yaw = 0, pitch = 0, roll = 0 } = {}) {
    const turn = (axis, degrees) => `rotate${axis}(${Number.isFinite(degrees) ? degrees : 0}deg)`;
    const turns = [turn("Y", yaw), turn("X", -pitch), turn("Z", -roll)];
    // Seen from four times the width.
    this.canvas.style.transform = `perspective(${4 * (this.canvas.clientWidth || this.canvas.width)}px) ${turns.join(" ")}`;
  }

  /** Shows places of the vertices that the host projected: x and y, in the order of the file's `vertices`. */
  positions(places, { yaw = 0, pitch = 0 } = {}) {
    this.paint(places, { yaw, pitch });
  }

  /** Plays a clip by its name or number, in a loop; with `audio`, in time with it. */
  play(clip = 0, { audio = null } = {}) {
    this.stop();
    this.clip = typeof clip === "number" ? this.clips[clip] : this.clips.find((c) => c.name === clip);
    if (!this.clip) throw new Error(`there is no clip ${clip}`);
    const started = performance.now();
    const step = (now) => {
      const seconds = audio ? audio.currentTime : (now - started) / 1000;
      this.show(seconds);
      this.frames += 1;
      this.running = requestAnimationFrame(step);
    };
    this.running = requestAnimationFrame(step);
    if (audio) return audio.play();
    return Promise.resolve();
  }

  /** Stops the clock. */
  stop() {
    cancelAnimationFrame(this.running);
    this.running = 0;
  }

  /** Stops the clock and shows one moment of the clip. */
  seek(seconds) {
    this.stop();
    this.show(seconds);
    return Promise.resolve();
  }

  show(seconds) {
    const clip = this.clip ?? this.clips[0];
    if (!clip) return this.draw({ yaw: 0, pitch: 0, roll: 0 }, []);
    const last = clip.frames - 1;
    this.seconds = last > 0 ? Math.max(0, seconds) % (last / clip.rate) || 0 : 0;
    const at = last > 0 ? Math.max(0, seconds * clip.rate) % last || 0 : 0;
    const before = Math.floor(at);
    const after = Math.min(before + 1, last);
    const mix = (list, width, i) => {
      const a = list[before * width + i];
      return a + (list[after * width + i] - a) * (at - before);
    };
    const [yaw, pitch, roll] = [0, 1, 2].map((i) => mix(clip.poses, 3, i) / 100);
    const weights = new Array(this.expressions.length).fill(0);
    clip.driven.forEach((e, i) => {
      weights[e] = mix(clip.weights, clip.driven.length, i) / 4096;
    });
    return this.draw({ yaw, pitch, roll }, weights);
  }

  draw(pose, weights) {
    const started = performance.now();
    this.shown = this.levelled(weights);
    this.paint(this.places(pose, this.shown), pose);
    this.judge(performance.now() - started);
  }

  /** The level that is shown. */
  get level() {
    return LEVELS[this.coarse];
  }

  /** Sets the level; with "auto" it follows the times of the frames, from the finest on. An unknown name does nothing. */
  set level(name) {
    if (name !== "auto" && !LEVELS.includes(name)) return;
    this.isAuto = name === "auto";
    this.coarse = Math.max(LEVELS.indexOf(name), 0);
    Object.assign(this, { judged: 0, spent: 0, before: Infinity, rests: 0, wait: TRIED_AGAIN });
  }

  /** Goes to a coarser level where frames take longer than the budget, back where it saves nothing or there is room. */
  judge(milliseconds) {
    this.judged += 1;
    this.spent += milliseconds;
    this.rests = Math.max(this.rests - 1, 0);
    if (!this.isAuto || this.judged < JUDGED) return;
    const mean = this.spent / this.judged;
    const { before } = this;
    Object.assign(this, { judged: 0, spent: 0, before: Infinity });
    if (before < Infinity && mean > (1 - SAVED) * before) {
      this.coarse -= 1;
      this.rests = this.wait;
      this.wait *= 2;
    } else if (mean > this.budget && this.coarse + 1 < LEVELS.length && this.rests === 0) {
      this.coarse += 1;
      this.before = mean;
    } else if (mean < ROOM * this.budget && this.coarse > 0) {
      this.coarse -= 1;
    }
  }

  /** Pixels of the screen in one of the document. */
  get pixels() {
    const { clientWidth, clientHeight } = this.canvas;
    if (!clientWidth || !clientHeight) return this.scale;
    const [width, height] = this.json.size;
    return Math.min(clientWidth / width, clientHeight / height) * (globalThis.devicePixelRatio ?? 1);
  }

  /** How far an expression moves a vertex at weight 1 when the head is turned to any side, pixels of the document. */
  reach({ vertices, modes }) {
    const { yaw: yaws, pitch: pitches } = this.json.grid;
    const rank = modes.length;
    const stride = this.rest.length + 1;
    const level = pitches.reduce((best, pitch, p) => (Math.abs(pitch) < Math.abs(pitches[best]) ? p : best), 0);
    let most = 0;
    for (let y = 0; y < yaws.length; y++) {
      const first = 2 * (level * yaws.length + y) * stride + 1;
      for (let i = 0; i < vertices.length; i++) {
        let [across, down] = [0, 0];
        for (let k = 0; k < rank; k++) {
          across += this.coefficients[first + k] * modes[k][i];
          down += this.coefficients[first + stride + k] * modes[k][i];
        }
        most = Math.max(most, Math.hypot(across, down));
      }
    }
    return most;
  }

  /** Weights at the level: some are those of others, some are 0, and so are those of motions too small to be seen. */
  levelled(weights) {
    const level = this.json.levels?.[this.level];
    const of = level ? level.expressions.map((e) => (e < 0 ? 0 : weights[e] ?? 0)) : [...weights];
    for (const [fap, parts] of level ? this.intervals : []) {
      const leader = level.faps[fap - 1];
      const lead = leader ? this.intervals.get(leader) : [];
      // A parameter that the table does not show has no value that could be copied.
      if (leader === fap || !lead) continue;
      const value = lead.reduce((sum, { from, to, expression }) => sum + (weights[expression] ?? 0) * (to - from), 0);
      for (const { from, to, expression, least, most } of parts) {
        of[expression] = Math.min(Math.max((value - from) / (to - from), least), most);
      }
    }
    const pixels = this.pixels;
    return of.map((weight, e) => (this.reaches[e] * pixels > UNSEEN ? weight : 0));
  }

  /** The two triangles at each edge. */
  findNeighbours() {
    const edges = new Map();
    // A triangle's own back is no neighbour.
    const own = (t) => [...this.triangles.subarray(3 * t, 3 * t + 3)].sort((a, b) => a - b).join();
    const key = (t, i) => {
      const a = this.triangles[3 * t + i];
      const b = this.triangles[3 * t + ((i + 1) % 3)];
      return Math.min(a, b) * 65536 + Math.max(a, b);
    };
    for (let t = 0; t < this.count; t++) {
      for (let i = 0; i < 3; i++) edges.set(key(t, i), [...(edges.get(key(t, i)) ?? []), t]);
    }
    return Int32Array.from({ length: 3 * this.count }, (_, j) => {
      const t = Math.floor(j / 3);
      return edges.get(key(t, j % 3)).find((n) => own(n) !== own(t)) ?? -1;
    });
  }

  /** Where the vertices are: modes over the nodes of the grid, blended between four of them. */
  places({ yaw, pitch, roll }, weights) {
    const { yaw: yaws, pitch: pitches } = this.json.grid;
    const rank = this.rest.length;
    const shape = this.rest.map((mode) => mode.slice());
    this.expressions.forEach(({ vertices, modes }, e) => {
      const weight = weights[e];
      if (!weight) return;
      modes.forEach((mode, k) => mode.forEach((value, i) => (shape[k][vertices[i]] += value * weight)));
    });
    const between = (nodes, value) => {
      const held = Math.min(Math.max(value, nodes[0]), nodes[nodes.length - 1]);
      let at = 0;
      while (at + 2 < nodes.length && nodes[at + 1] <= held) at++;
      return nodes.length < 2 ? [0, 0] : [at, (held - nodes[at]) / (nodes[at + 1] - nodes[at])];
    };
    const [y, right] = between(yaws, yaw);
    const [p, up] = between(pitches, pitch);
    const stride = 2 * (rank + 1);
    const mixed = new Float32Array(stride);
    for (const [dy, dp, share] of [
      [0, 0, (1 - right) * (1 - up)],
      [1, 0, right * (1 - up)],
      [0, 1, (1 - right) * up],
      [1, 1, right * up],
    ]) {
      const first = ((p + dp) * yaws.length + y + dy) * stride;
      if (share > 0) for (let i = 0; i < stride; i++) mixed[i] += share * this.coefficients[first + i];
    }
    const count = shape.length ? shape[0].length : 0;
    const out = new Float32Array(2 * count);
    for (let v = 0; v < count; v++) {
      let x = mixed[0];
      let z = mixed[rank + 1];
      for (let k = 0; k < rank; k++) {
        x += mixed[1 + k] * shape[k][v];
        z += mixed[rank + 2 + k] * shape[k][v];
      }
      out[2 * v] = x;
      out[2 * v + 1] = z;
    }
    if (roll) this.tilt(out, roll);
    return out;
  }

  tilt(places, roll) {
    const { pivot, size, blends } = this.json;
    for (let v = 0; 2 * v < places.length; v++) {
      const part = this.tilts[v] / 255;
      const angle = ((-roll * Math.PI) / 180) * (blends ? 1 : part);
      const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
      // The pivot at the depth of the vertex.
      const [px, py] = pivot.map((p, i) => p + ((p - size[i] / 2) * this.depths[v]) / 256);
      const [x, y] = [places[2 * v] - px, places[2 * v + 1] - py];
      const turned = [px + cos * x - sin * y, py + sin * x + cos * y];
      for (const i of [0, 1]) places[2 * v + i] += (blends ? part : 1) * (turned[i] - places[2 * v + i]);
    }
  }

  corners(places, t) {
    const out = [];
    for (let i = 0; i < 3; i++) {
      const v = this.triangles[3 * t + i];
      out.push(places[2 * v], places[2 * v + 1]);
    }
    return out;
  }

  /** Positive where the front is seen. */
  area(places, t) {
    const [ax, ay, bx, by, cx, cy] = this.corners(places, t);
    return -0.5 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax));
  }

  /** How much each view counts: the square of its share of the triangle's area, the nearer more. */
  weights(t, area, near) {
    const shown = Math.max(Math.abs(area), 1e-3);
    const found = this.views.map((view, i) => {
      if (view.layers[t] === 255) return 0;
      const ratio = Math.min(Math.abs(view.areas[t]) / shown, 2);
      return ratio * ratio * near[i];
    });
    const sum = found.reduce((a, b) => a + b, 0);
    if (sum > 0) return found.map((w) => w / sum);
    const areas = this.views.map((view) => Math.abs(view.areas[t]));
    const best = areas.indexOf(Math.max(...areas));
    return found.map((_, i) => (i === best ? 1 : 0));
  }

  near({ yaw, pitch }) {
    const fall = (a, b, span) => (span > 0 ? Math.max(1 - Math.abs(a - b) / span, 0.004) : 1);
    return this.views.map((v) => fall(v.yaw, yaw, this.spans[0]) * fall(v.pitch, pitch, this.spans[1]));
  }

  /** Corners moved outward under neighbours that come later, and a little over earlier ones. */
  sealed(c, edges) {
    const [parallel, farthest] = [0.15, 2];
    if (!edges[0] && !edges[1] && !edges[2]) return c;
    const turned = Math.sign((c[2] - c[0]) * (c[5] - c[1]) - (c[3] - c[1]) * (c[4] - c[0]));
    const normals = [0, 1, 2].map((i) => {
      const j = (i + 1) % 3;
      const [x, y] = [c[2 * j] - c[2 * i], c[2 * j + 1] - c[2 * i + 1]];
      const length = Math.hypot(x, y) || 1;
      return [(y / length) * turned, (-x / length) * turned];
    });
    const out = [];
    for (let i = 0; i < 3; i++) {
      const before = (i + 2) % 3;
      const [d0, d1] = [edges[before], edges[i]];
      const [n0, n1] = [normals[before], normals[i]];
      const det = n0[0] * n1[1] - n0[1] * n1[0];
      let [x, y] = [0, 0];
      if (Math.abs(det) < parallel) {
        x = c[2 * i] - (c[0] + c[2] + c[4]) / 3;
        y = c[2 * i + 1] - (c[1] + c[3] + c[5]) / 3;
        const scale = Math.max(d0, d1) / (Math.hypot(x, y) || 1);
        [x, y] = [x * scale, y * scale];
      } else {
        x = (d0 * n1[1] - d1 * n0[1]) / det;
        y = (d1 * n0[0] - d0 * n1[0]) / det;
      }
      const length = Math.hypot(x, y);
      const held = length > farthest ? farthest / length : 1;
      out.push(c[2 * i] + x * held, c[2 * i + 1] + y * held);
    }
    return out;
  }

  /** The map from a view's picture to the portrait; a sliver in the view takes one colour. */
  map(from, to) {
    const [ux, uy, vx, vy] = [from[2] - from[0], from[3] - from[1], from[4] - from[0], from[5] - from[1]];
    const [px, py, qx, qy] = [to[2] - to[0], to[3] - to[1], to[4] - to[0], to[5] - to[1]];
    const det = ux * vy - uy * vx;
    if (Math.abs(det) < 0.1) {
      const middle = (c, i) => (c[i] + c[i + 2] + c[i + 4]) / 3;
      return [8, 0, 0, 8, middle(to, 0) - 8 * middle(from, 0), middle(to, 1) - 8 * middle(from, 1)];
    }
    const a = (px * vy - qx * uy) / det;
    const c = (qx * ux - px * vx) / det;
    const b = (py * vy - qy * uy) / det;
    const d = (qy * ux - py * vx) / det;
    return [a, b, c, d, to[0] - a * from[0] - c * from[1], to[1] - b * from[0] - d * from[1]];
  }

  paint(places, pose) {
    const context = this.context;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = 1;
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    const slide = this.slides.findLast(({ from }) => from <= this.seconds);
    if (slide) context.drawImage(slide.picture, 0, 0, this.canvas.width, this.canvas.height);
    const near = this.near(pose);
    let { order } = this.sectors[0];
    for (const sector of this.sectors) if (sector.from <= pose.yaw) order = sector.order;
    const areas = Float32Array.from({ length: this.count }, (_, t) => this.area(places, t));
    const shows = (t) => areas[t] > 0.02;
    const painted = new Uint8Array(this.count);
    for (const t of order) {
      painted[t] = 1;
      if (!shows(t)) continue;
      const corners = this.corners(places, t);
      const reach = [0, 1, 2].map((i) => {
        const n = this.neighbours[3 * t + i];
        if (n < 0 || !shows(n)) return 0;
        return painted[n] ? 0.35 : 0.8;
      });
      this.fill(t, corners, this.sealed(corners, reach), this.weights(t, areas[t], near));
    }
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.globalAlpha = 1;
  }

  /** Paints a triangle with each view that counts, the strongest first, so that all blend by weight. */
  fill(t, corners, grown, weights) {
    const taken = weights.map((w, i) => [w, this.views[i]]).filter(([w]) => w >= 0.03);
    taken.sort((a, b) => b[0] - a[0]);
    let sum = 0;
    for (const [weight, view] of taken) {
      sum += weight;
      const [shiftX, shiftY] = view.shifts[view.layers[t]] ?? [0, 0];
      const there = this.corners(view.places, t).map((x, i) => x + (i % 2 ? shiftY : shiftX));
      const [a, b, c, d, e, f] = this.map(there, corners);
      const det = a * d - b * c;
      if (!(Math.abs(det) > 1e-9)) continue;
      const context = this.context;
      context.globalAlpha = weight / sum;
      context.fillStyle = view.pattern;
      context.setTransform(...[a, b, c, d, e, f].map((x) => x * this.scale));
      context.beginPath();
      for (let i = 0; i < 6; i += 2) {
        const [x, y] = [grown[i] - e, grown[i + 1] - f];
        const [u, v] = [(d * x - c * y) / det, (a * y - b * x) / det];
        if (i) context.lineTo(u, v);
        else context.moveTo(u, v);
      }
      context.fill();
    }
  }
}

if (typeof window !== "undefined") window.ArticulaPortrait = ArticulaPortrait;
if (typeof module !== "undefined") module.exports = { ArticulaPortrait };
