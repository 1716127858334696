// Visemes of speech by two libraries from npm that run in pages: headaudio, and wlipsync with a profile made
// of speech with known shapes, since it has none of its own.
//
//   node visemes.mjs headaudio|wlipsync JOB.json
//
// JOB.json has `clips`, files of 32-bit samples at 16 kHz, and `profile`, a list of such files with the number
// of the shape of each hundredth of a second. Printed is a list with one entry for each clip: for each
// hundredth of a second the weights of the 15 visemes in the order of MPEG-4.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const RATE_HZ = 16000;
const ORDER = ["sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "I", "O", "U"];
// Root mean square of what both hear: a voice at the level of a microphone.
const LEVEL = 0.1;

const require = createRequire(import.meta.url);
const folderOf = (name) => join(dirname(require.resolve("./package.json")), "node_modules", name);

const samplesOf = (file) => {
  const bytes = readFileSync(file);
  const samples = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4).slice();
  const power = samples.reduce((sum, s) => sum + s * s, 0) / Math.max(samples.length, 1);
  const gain = LEVEL / Math.sqrt(power || 1);
  return samples.map((s) => s * gain);
};

const frameCount = (samples) => Math.floor((samples.length * 100) / RATE_HZ);

// Runs its node and its processor, joined by their ports, as a page does.
const headaudio = async () => {
  globalThis.AudioWorkletNode = class {
    constructor(context, name, options) {
      this.parameters = new Map();
      this.port = { postMessage: (data) => this.processor?._onmessage({ data }) };
      this.options = options;
    }
  };
  const folder = folderOf("@met4citizen/headaudio");
  const load = (name) => import(pathToFileURL(join(folder, "modules", name)));
  const { HeadAudio } = await load("headaudio.mjs");
  const { Processor } = await load("processor.mjs");
  const model = readFileSync(join(folder, "dist/model-en-mixed.bin"));
  globalThis.fetch = async () => ({ ok: true, arrayBuffer: async () => model.buffer.slice(model.byteOffset, model.byteOffset + model.length) });
  return async (samples) => {
    const node = new HeadAudio({}, {});
    const worklet = { port: { postMessage: (data) => node.port.onmessage({ data }) } };
    node.processor = new Processor({ sampleRate: RATE_HZ }, worklet);
    await node.loadModel("model");
    const weights = Object.fromEntries(node.visemeNames.map((name) => [name, 0]));
    node.onvalue = (name, value) => { weights[name] = value; };
    const frames = [];
    for (let frame = 0; frame < frameCount(samples); frame++) {
      node.processor.process(samples.subarray((frame * RATE_HZ) / 100, ((frame + 1) * RATE_HZ) / 100));
      node.update(10);
      const shown = ORDER.slice(1).map((name) => weights[`viseme_${name}`]);
      const rest = 1 - shown.reduce((sum, w) => sum + w, 0);
      frames.push([Math.max(rest, 0), ...shown]);
    }
    return frames;
  };
};

// Its WebAssembly, called as its processor and node do.
const wlipsync = async (job) => {
  const folder = folderOf("wlipsync");
  const memory = new WebAssembly.Memory({ initial: 4 });
  const bytes = readFileSync(join(folder, "dist/wlipsync.wasm"));
  const { instance: { exports } } = await WebAssembly.instantiate(bytes, { env: { memory } });
  const COEFFICIENTS = 12;
  const SHAPES = ORDER.length - 1;
  const [WINDOW, BANDS, COSINE, BLOCK] = [1024, 30, 2, 512];
  exports.load_profile(RATE_HZ, WINDOW, BANDS, COSINE, SHAPES, 1, 0);
  exports.set_input(RATE_HZ);
  const size = exports.get_input_buffer_size();
  const input = new Float32Array(memory.buffer, exports.get_input_buffer(), size);
  const volume = new Float32Array(memory.buffer, exports.get_volume_ptr(), 1);
  const coefficients = new Float32Array(memory.buffer, exports.mfccOut.value, COEFFICIENTS);
  // Calls `heard` after each block with the sample that follows it and the strongest shape.
  const run = (samples, heard) => {
    input.fill(0);
    for (let at = 0; at + BLOCK <= samples.length; at += BLOCK) {
      for (let i = 0; i < BLOCK; i++) input[(at + i) % size] = samples[at + i];
      heard(at + BLOCK, exports.execute((at + BLOCK) % size));
    }
  };
  const sums = Array.from({ length: SHAPES }, () => new Float64Array(COEFFICIENTS));
  const counts = new Float64Array(SHAPES);
  for (const { file, shapes } of job.profile) {
    run(samplesOf(file), (end) => {
      const shape = shapes[Math.floor(((end - WINDOW / 2) * 100) / RATE_HZ)];
      if (!shape) return;
      counts[shape - 1] += 1;
      coefficients.forEach((value, i) => { sums[shape - 1][i] += value; });
    });
  }
  const [mfccs, means, deviations] = new Int32Array(memory.buffer, exports.get_profile_ptrs(), 3);
  const profile = new Float32Array(memory.buffer, mfccs, SHAPES * COEFFICIENTS);
  sums.forEach((sum, shape) => sum.forEach((value, i) => { profile[shape * COEFFICIENTS + i] = value / Math.max(counts[shape], 1); }));
  new Float32Array(memory.buffer, means, COEFFICIENTS).fill(0);
  new Float32Array(memory.buffer, deviations, COEFFICIENTS).fill(1);
  // The critically damped spring of its node (Unity's SmoothDamp) and its limits of volume.
  const SMOOTHNESS = 0.05;
  const [QUIET, LOUD] = [-2.5, -1.5];
  const follow = (state, target, secs) => {
    const omega = 2 / SMOOTHNESS;
    const x = omega * secs;
    const decay = 1 / (1 + x + 0.48 * x * x + 0.235 * x * x * x);
    const change = state.value - target;
    const moved = (state.velocity + omega * change) * secs;
    state.value = target + (change + moved) * decay;
    state.velocity = (state.velocity - omega * moved) * decay;
  };
  return async (samples) => {
    const loud = { value: 0, velocity: 0 };
    const states = ORDER.slice(1).map(() => ({ value: 0, velocity: 0 }));
    const frames = [];
    const fill = (count) => {
      const shown = states.map(({ value }) => Math.max(value, 0) * loud.value);
      const rest = Math.max(1 - shown.reduce((sum, w) => sum + w, 0), 0);
      while (frames.length < count) frames.push([rest, ...shown]);
    };
    run(samples, (end, strongest) => {
      fill(Math.floor((end * 100) / RATE_HZ));
      const level = (Math.log10(volume[0] || 1e-9) - QUIET) / (LOUD - QUIET);
      follow(loud, Math.max(Math.min(level, 1), 0), BLOCK / RATE_HZ);
      states.forEach((state, shape) => follow(state, shape === strongest ? 1 : 0, BLOCK / RATE_HZ));
    });
    fill(frameCount(samples));
    return frames;
  };
};

const [peer, file] = process.argv.slice(2);
const job = JSON.parse(readFileSync(file, "utf8"));
const recognise = await { headaudio, wlipsync }[peer](job);
const clips = [];
for (const clip of job.clips) clips.push(await recognise(samplesOf(clip)));
process.stdout.write(JSON.stringify(clips, (_, value) => (typeof value === "number" ? Number(value.toFixed(4)) : value)));
