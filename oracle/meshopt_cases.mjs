// Random data through the encoder of npm `meshoptimizer`: `node meshopt_cases.mjs SEED COUNT`.
// Prints one JSON object a line: {mode, filter, count, stride, encoded, reference, library},
// bytes in hexadecimal. `reference` is what the package's plain reference decoder gives,
// `library` what its compiled one gives. A line with a change in `encoded` has no `reference`,
// and no `library` if that decoder refuses it.

import { MeshoptDecoder as library } from "meshoptimizer/decoder";
import { MeshoptEncoder as encoder } from "meshoptimizer/encoder";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

const packaged = dirname(createRequire(import.meta.url).resolve("meshoptimizer"));
const reference = (await import(pathToFileURL(join(packaged, "meshopt_decoder_reference.js")).href)).MeshoptDecoder;

const [seed, cases] = process.argv.slice(2).map(Number);
if (!Number.isInteger(seed) || !Number.isInteger(cases)) {
  console.error("usage: node meshopt_cases.mjs SEED COUNT");
  process.exit(2);
}
await Promise.all([library.ready, encoder.ready]);

/** The same numbers on every machine (mulberry32). */
let state = seed >>> 0;
function random() {
  state = (state + 0x6d2b79f5) >>> 0;
  let t = state;
  t = Math.imul(t ^ (t >>> 15), t | 1);
  t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
  return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
}
const below = (end) => Math.floor(random() * end);
const pick = (list) => list[below(list.length)];
const between = (least, most) => least + (most - least) * random();

/** Lengths around the sizes of groups and blocks, and others. */
const someCount = () => pick([1, 2, 15, 16, 17, 31, 64, 65, 255, 256, 257, 1 + below(700)]);

/** Elements whose 4-byte words walk, jump, stand still or are noise. */
function someElements(count, stride) {
  const bytes = new Uint8Array(count * stride);
  const view = new DataView(bytes.buffer);
  for (let word = 0; word < stride; word += 4) {
    const kind = pick(["still", "noise", "bytes", "shorts", "floats", "bits"]);
    const pace = 2 ** below(12);
    let value = below(2 ** 32);
    let float = between(-10, 10);
    for (let i = 0; i < count; i++) {
      const at = i * stride + word;
      if (kind === "noise") value = below(2 ** 32);
      if (kind === "bits" && below(4) === 0) value = (value ^ (1 << below(32))) >>> 0;
      view.setUint32(at, value, true);
      if (kind === "floats") view.setFloat32(at, (float += between(-pace, pace) / 1000), true);
      if (kind === "bytes") {
        for (let b = 0; b < 4; b++) view.setUint8(at + b, view.getUint8(at + b) + below(Math.min(pace, 64)));
        value = view.getUint32(at, true);
      }
      if (kind === "shorts") {
        for (let s = 0; s < 4; s += 2) view.setUint16(at + s, view.getUint16(at + s, true) + below(pace), true);
        value = view.getUint32(at, true);
      }
    }
  }
  return bytes;
}

function unit(parts) {
  const vector = Array.from({ length: parts }, () => between(-1, 1));
  const length = Math.hypot(...vector) || 1;
  return vector.map((x) => x / length);
}

/** Elements made ready for a filter, and their stride. */
function filtered(filter, count) {
  const stride = pick([4, 8]);
  const floats = (make) => new Float32Array(Array.from({ length: count }, make).flat());
  switch (filter) {
    case "OCTAHEDRAL": {
      const bits = stride === 4 ? 2 + below(7) : 2 + below(15);
      return [encoder.encodeFilterOct(floats(() => [...unit(3), between(-1, 1)]), count, stride, bits), stride];
    }
    case "QUATERNION":
      return [encoder.encodeFilterQuat(floats(() => unit(4)), count, 8, 4 + below(13)), 8];
    case "COLOR": {
      const bits = stride === 4 ? 2 + below(7) : 2 + below(15);
      return [encoder.encodeFilterColor(floats(() => [random(), random(), random(), random()]), count, stride, bits), stride];
    }
    default: {
      const words = 1 + below(16);
      const scale = 10 ** between(-8, 8);
      const source = floats(() => Array.from({ length: words }, () => between(-scale, scale)));
      const mode = pick(["Separate", "SharedVector", "SharedComponent", "Clamped"]);
      return [encoder.encodeFilterExp(source, count, words * 4, 1 + below(24), mode), words * 4];
    }
  }
}

/** A strip of triangles, in order, cut, or shuffled. */
function someTriangles(stride) {
  const columns = 1 + below(20);
  const rows = 1 + below(20);
  const first = pick([0, 0, below(60000), stride === 4 ? below(2 ** 31) : 0]);
  const triangles = [];
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      const a = first + y * (columns + 1) + x;
      const [b, c, d] = [a + 1, a + columns + 1, a + columns + 2];
      triangles.push([a, b, c], [c, b, d]);
    }
  }
  if (below(3) === 0) triangles.sort(() => random() - 0.5);
  if (below(3) === 0) triangles.forEach((triangle) => triangle.push(...triangle.splice(0, below(3))));
  if (below(4) === 0) triangles.push(...triangles);
  return triangles.flat();
}

function someIndices(stride) {
  const most = stride === 2 ? 65536 : 2 ** 30;
  let [near, far] = [below(most), below(most)];
  return Array.from({ length: someCount() }, () => {
    if (below(30) === 0) far = below(most);
    if (below(2) === 0) return (near = (near + below(5)) % most);
    return (far = Math.max(0, far - below(300)));
  });
}

/** One encoded view. */
function someCase() {
  const kind = pick(["NONE", "NONE", "NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR", "TRIANGLES", "INDICES"]);
  if (kind === "TRIANGLES" || kind === "INDICES") {
    const stride = pick([2, 4]);
    const list = kind === "TRIANGLES" ? someTriangles(stride) : someIndices(stride);
    const source = new Uint8Array((stride === 2 ? new Uint16Array(list) : new Uint32Array(list)).buffer);
    const encoded = encoder.encodeGltfBuffer(source, list.length, stride, kind);
    return { mode: kind, filter: "NONE", count: list.length, stride, encoded };
  }
  const count = someCount();
  const plain = 4 * (1 + below(64));
  const [source, stride] = kind === "NONE" ? [someElements(count, plain), plain] : filtered(kind, count);
  const encoded = encoder.encodeVertexBufferLevel(source, count, stride, below(4), below(2));
  return { mode: "ATTRIBUTES", filter: kind, count, stride, encoded };
}

function decoded(decoder, { mode, filter, count, stride, encoded }) {
  const target = new Uint8Array(count * stride);
  decoder.decodeGltfBuffer(target, count, stride, encoded, mode, filter);
  return Buffer.from(target).toString("hex");
}

/** The same view with a few bytes changed, dropped or added. */
function changed(encoded) {
  const bytes = [...encoded];
  for (let i = 0; i <= below(3); i++) {
    const at = below(bytes.length);
    const how = below(8);
    if (how === 0) bytes.splice(at, 1);
    else if (how === 1) bytes.splice(at, 0, below(256));
    else bytes[at] = how < 4 ? below(256) : bytes[at] ^ (1 << below(8));
  }
  return new Uint8Array(bytes);
}

const print = (line) => process.stdout.write(`${JSON.stringify({ ...line, encoded: Buffer.from(line.encoded).toString("hex") })}\n`);
for (let i = 0; i < cases; i++) {
  const good = someCase();
  print({ ...good, reference: decoded(reference, good), library: decoded(library, good) });
  // What a filter does to numbers outside its range is left open, so changes go without one.
  const bad = { ...good, filter: "NONE", encoded: changed(good.encoded) };
  let answer = null;
  try {
    answer = decoded(library, bad);
  } catch {
    // Refused.
  }
  print({ ...bad, reference: null, library: answer });
}
