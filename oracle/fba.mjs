// MPEG-4 binary face streams (`.fba`, predictive mode) read and written apart from Articula:
//   node fba.mjs decode FILE        prints the planes as JSON: every decision of the writer, and values
//   node fba.mjs encode PLAN FILE   writes the stream that such planes describe
//   node fba.mjs frames FILE        prints a line for each frame: number, then `parameter=value`
//   node fba.mjs golden FOLDER      writes the streams of fba_clips.mjs, and their frames as text
//
// Written from facts about the format (docs/formats/fba.md names the sources), not from Articula's
// code, and the plain way: no fast sums, bits as numbers.
//
// A plane: {startCode?, intra, frameRate?: [rate, sixteenths, offset], timeCode?: [h, m, s], skip?,
// and if intra quantiser, masks: ten of "type" or "type bits", gender, ranges: [greatest and least of
// intra frames, of predicted frames], each null or a k for every coded parameter from 3 up;
// viseme?: [first, second, blend, def], expression?: [first, intensity, second, intensity, init, def],
// values: {parameter: value}}. Decoded values are what a receiver shows.

import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { BitReader, BitWriter, Model, RunReader, RunWriter } from "./fba_run.mjs";

/** Start codes, today's first and then that of old streams. */
const OBJECT = [0x000001ba, 0x00000101];
const PLANE = [0x000001bb, 0x00000103];
const END = [0x000001b1];

/** First parameter of each group, and the end. */
const GROUPS = [1, 3, 19, 31, 39, 43, 48, 51, 61, 65, 69];

/** Parameters, step, greatest level of intra frames and of predicted ones. */
const PARAMETERS = new Map();
for (const [parameters, step, intra, predicted] of [
  ["3", 4, 1080, 360],
  ["4 6-9 12 13 51 53-56 59 60", 2, 600, 180],
  ["5 10 11 52 57 58", 2, 1860, 600],
  ["14", 1, 600, 180],
  ["15-17", 1, 1080, 360],
  ["18", 1, 420, 180],
  ["19 20", 1, 1080, 600],
  ["21 22", 1, 600, 240],
  ["23 24", 128, 1200, 420],
  ["25 26", 128, 900, 300],
  ["27 28", 1, 600, 180],
  ["29 30", 1, 420, 120],
  ["31-36", 2, 900, 360],
  ["37 38", 1, 900, 300],
  ["39 40", 2, 900, 300],
  ["41 42", 2, 600, 180],
  ["43-46", 1, 1080, 420],
  ["47", 512, 1080, 420],
  ["48-50", 170, 1860, 600],
  ["61 62", 1, 540, 120],
  ["63", 1, 680, 180],
  ["64", 1, 900, 180],
  ["65 66", 1, 900, 240],
  ["67 68", 1, 900, 300],
]) {
  for (const part of parameters.split(" ")) {
    const [first, last = first] = part.split("-").map(Number);
    for (let fap = first; fap <= last; fap++) PARAMETERS.set(fap, { step, intra, predicted });
  }
}

/** Fields of parameters 1 and 2: greatest value, and whether the quantiser applies. */
const HIGH = {
  viseme: [[14, false], [14, false], [63, true]],
  expression: [[6, false], [63, true], [6, false], [63, true]],
};
/** Bits after the run of a high-level parameter. */
const RAW = { viseme: 1, expression: 2 };

const towardsZero = (a, b) => Math.trunc(a / b) + 0;
const quantise = (value, step) => {
  if (step === 0) return value;
  const half = Math.floor(step / 2);
  const size = Math.abs(value);
  return size <= half ? 0 : Math.sign(value) * Math.floor((size + half) / step);
};
const dequantise = (level, step) => (step === 0 ? level : level * step);
const clamp = (value, { least, greatest }) => Math.min(Math.max(value, least), greatest);

/** What a stream keeps from plane to plane, alike for writer and reader. */
class State {
  mask = [];
  high = { viseme: [0, 0, 0], expression: [0, 0, 0, 0] };
  values = new Map();
  ranges = null;
  highBounds = 63;

  masks(groups) {
    this.mask = [];
    groups.forEach((group, g) => {
      const [type, bits = ""] = group.split(" ");
      for (let fap = GROUPS[g]; fap < GROUPS[g + 1]; fap++) {
        if (type === "3" || (type !== "0" && bits[fap - GROUPS[g]] === "1")) this.mask.push(fap);
      }
    });
    this.low = this.mask.filter((fap) => fap > 2);
  }
  /** Ranges of levels: the table's at first, then those that were sent, each with the quantiser of its plane. */
  intra({ quantiser, ranges }) {
    this.quantiser = quantiser;
    const scale = quantiser || 1;
    this.ranges ??= new Map(
      [...PARAMETERS].map(([fap, { intra, predicted }]) => {
        const [i, p] = [intra, predicted].map((size) => towardsZero(60 * Math.ceil(size / 60), scale));
        return [fap, { intra: { least: -i, greatest: i }, predicted: { least: -p, greatest: p } }];
      }),
    );
    ranges.forEach((range, which) => {
      range?.forEach((k, i) => {
        const kinds = this.ranges.get(this.low[i]);
        const kind = which < 2 ? kinds.intra : kinds.predicted;
        if (which % 2 === 0) kind.greatest = towardsZero(60 * k, scale);
        else kind.least = towardsZero(-60 * k, scale);
      });
    });
    if (quantiser !== 0) this.highBounds = Math.floor((63 + Math.floor(quantiser / 2)) / quantiser);
    this.models = { intra: this.newModels("intra"), predicted: this.newModels("predicted") };
  }
  newModels(kind) {
    const models = new Map(this.low.map((fap) => [fap, new Model(this.ranges.get(fap)[kind])]));
    for (const [name, fields] of Object.entries(HIGH)) {
      const of = ([size, quantised]) => {
        const greatest = quantised ? this.highBounds : size;
        return new Model({ least: kind === "intra" ? 0 : -greatest, greatest });
      };
      models.set(name, fields.map(of));
    }
    return models;
  }
  /** Codes one number: `level` gives or takes the level that is in the stream. */
  step(model, size, before, intra, level) {
    const base = intra ? 0 : before;
    const coded = level(model, base, size);
    if (!intra) model.learn(coded - model.least);
    return base + dequantise(coded, size);
  }
  /** Codes the runs of a plane. `run()` begins one, `raw` codes bits between them. */
  runs(plane, intra, run, raw) {
    const models = this.models[intra ? "intra" : "predicted"];
    for (const [fap, name] of [[1, "viseme"], [2, "expression"]]) {
      if (!this.mask.includes(fap)) {
        delete plane[name];
        continue;
      }
      const coder = run();
      this.high[name] = this.high[name].map((before, i) => {
        const size = HIGH[name][i][1] ? this.quantiser : 1;
        return this.step(models.get(name)[i], size, before, intra, (...a) => coder.level(plane[name]?.[i], ...a));
      });
      coder.end();
      const flags = raw(plane[name]?.slice(-RAW[name]), RAW[name]);
      plane[name] = [...this.high[name], ...flags];
    }
    const coder = run();
    const shown = {};
    for (const fap of this.low) {
      const size = PARAMETERS.get(fap).step * this.quantiser;
      const before = this.values.get(fap) ?? 0;
      const value = this.step(models.get(fap), size, before, intra, (...a) => coder.level(plane.values?.[fap], ...a));
      this.values.set(fap, value);
      shown[fap] = value;
    }
    coder.end();
    plane.values = shown;
  }
}

/** Codes or reads the k of ranges: a marker before every fourth parameter of a group, coded or not. */
function walkRange(state, marker, each) {
  let coded = 0;
  for (let g = 1; g < 10; g++) {
    for (let fap = GROUPS[g]; fap < GROUPS[g + 1]; fap++) {
      if ((fap - GROUPS[g]) % 4 === 0) marker();
      if (state.mask.includes(fap)) each(coded++);
    }
  }
}

function writeSkip(out, skip) {
  for (; skip >= 15; skip -= 15) out.put(4, 15);
  out.put(4, skip);
}

function readSkip(from) {
  let sum = 0;
  let part;
  do sum += part = from.get(4);
  while (part === 15);
  return sum;
}

/** The bytes of a stream, and the planes as a receiver shows them. */
export function encode(planes) {
  const out = new BitWriter();
  const state = new State();
  out.put(32, OBJECT[0]);
  const shown = planes.map((given) => {
    const plane = structuredClone(given);
    if (plane.startCode) {
      out.stuff();
      out.put(32, PLANE[0]);
    }
    out.put(1, plane.intra ? 1 : 0);
    out.put(2, 1);
    if (plane.intra) {
      out.put(1, plane.frameRate ? 1 : 0);
      plane.frameRate?.forEach((field, i) => out.put([8, 4, 1][i], field));
      out.put(1, plane.timeCode ? 1 : 0);
      if (plane.timeCode) {
        const [h, m, s] = plane.timeCode;
        [[5, h], [6, m], [1, 1], [6, s]].forEach(([count, field]) => out.put(count, field));
      }
    }
    out.put(1, plane.skip === undefined ? 0 : 1);
    if (plane.skip !== undefined) writeSkip(out, plane.skip);
    if (plane.intra) {
      out.put(5, plane.quantiser);
      for (const group of plane.masks) {
        const [type, bits = ""] = group.split(" ");
        out.put(1, 1);
        out.put(2, Number(type));
        for (const bit of bits) out.put(1, Number(bit));
      }
      out.put(1, plane.gender ?? 0);
      out.put(1, 0);
      for (const range of plane.ranges) out.put(1, range ? 1 : 0);
      state.masks(plane.masks);
      for (const range of plane.ranges) {
        if (range) walkRange(state, () => out.put(1, 1), (i) => out.put(5, range[i]));
      }
      state.intra(plane);
    }
    const run = () => {
      const coder = new RunWriter(out);
      const level = (value, model, base, size) => {
        const coded = clamp(quantise(value - base, size), model);
        coder.symbol(model, coded - model.least);
        return coded;
      };
      return { level, end: () => coder.end() };
    };
    state.runs(plane, plane.intra, run, (bits) => (bits.forEach((bit) => out.put(1, bit)), bits));
    return plane;
  });
  out.stuff();
  out.put(32, END[0]);
  return { bytes: out.bytes(), planes: shown };
}

/** The planes of a stream. */
export function decode(bytes) {
  const from = new BitReader(bytes);
  const state = new State();
  if (!OBJECT.includes(from.get(32))) throw new Error("no fba_object_start_code");
  const planes = [];
  while (!from.takes(END)) {
    const plane = from.takes(PLANE) ? { startCode: true } : {};
    plane.intra = from.get(1) === 1;
    const mask = from.get(2);
    if (mask !== 1) throw new Error(`plane ${planes.length} is not of a face alone (mask ${mask})`);
    if (plane.intra) {
      if (from.get(1)) plane.frameRate = [8, 4, 1].map((count) => from.get(count));
      if (from.get(1)) {
        const hours = from.get(5);
        const minutes = from.get(6);
        from.marker();
        plane.timeCode = [hours, minutes, from.get(6)];
      }
    } else if (!state.models) throw new Error("the first plane is predicted");
    if (from.get(1)) plane.skip = readSkip(from);
    if (plane.intra) {
      plane.quantiser = from.get(5);
      plane.masks = GROUPS.slice(0, 10).map((first, g) => {
        from.marker();
        const type = from.get(2);
        if (type === 0 || type === 3) return String(type);
        const bits = Array.from({ length: GROUPS[g + 1] - first }, () => from.get(1));
        return `${type} ${bits.join("")}`;
      });
      plane.gender = from.get(1);
      if (from.get(1)) throw new Error("DCT-coded face stream");
      const flags = [1, 1, 1, 1].map((count) => from.get(count));
      state.masks(plane.masks);
      plane.ranges = flags.map((flag) => {
        if (!flag) return null;
        const range = [];
        walkRange(state, () => from.marker(), () => range.push(from.get(5)));
        return range;
      });
      state.intra(plane);
    }
    const run = () => {
      const coder = new RunReader(from);
      return { level: (_, model) => coder.symbol(model) + model.least, end: () => coder.end() };
    };
    state.runs(plane, plane.intra, run, (_, count) => Array.from({ length: count }, () => from.get(1)));
    planes.push(plane);
  }
  return planes;
}

/** A line for each frame with every parameter coded so far, and the rate. A plane that skips shows for longer. */
export function frames(planes) {
  const [rate, sixteenths, offset] = planes.find((plane) => plane.frameRate)?.frameRate ?? [30, 0, 0];
  const hz = rate + sixteenths / 16;
  const lines = [`rate ${offset ? (hz * 1000) / 1001 : hz}`];
  const held = new Map();
  let number = 0;
  for (const plane of planes) {
    for (const [fap, name] of [[1, "viseme"], [2, "expression"]]) {
      if (!plane[name]) continue;
      const kept = plane[name].map((field, i) => (HIGH[name][i]?.[1] ? Math.min(Math.max(field, 0), 63) : field));
      held.set(fap, kept.join(","));
    }
    for (const [fap, value] of Object.entries(plane.values)) held.set(Number(fap), value);
    const order = [...held].sort(([a], [b]) => a - b);
    lines.push([number, ...order.map(([fap, value]) => `${fap}=${value}`)].join(" "));
    number += 1 + (plane.skip ?? 0);
  }
  return `${lines.join("\n")}\n`;
}

async function main([verb, ...files]) {
  const stream = () => decode(readFileSync(files[0]));
  if (verb === "decode" && files.length === 1) {
    console.log(JSON.stringify(stream()));
  } else if (verb === "frames" && files.length === 1) {
    process.stdout.write(frames(stream()));
  } else if (verb === "encode" && files.length === 2) {
    writeFileSync(files[1], encode(JSON.parse(readFileSync(files[0], "utf8"))).bytes);
  } else if (verb === "golden" && files.length === 1) {
    for (const [name, planes] of Object.entries((await import("./fba_clips.mjs")).clips)) {
      const { bytes, planes: shown } = encode(planes);
      writeFileSync(join(files[0], `${name}.fba`), bytes);
      writeFileSync(join(files[0], `${name}.txt`), frames(shown));
    }
  } else {
    console.error("usage: node fba.mjs decode FILE | frames FILE | encode PLAN FILE | golden FOLDER");
    process.exitCode = 2;
  }
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? "").href) {
  try {
    await main(process.argv.slice(2));
  } catch (fault) {
    console.error(fault.message);
    process.exitCode = 1;
  }
}
