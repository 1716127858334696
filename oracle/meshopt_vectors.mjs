// The decoder vectors of npm `meshoptimizer` (MIT): `node meshopt_vectors.mjs`.
// Prints [{name, mode, filter, count, stride, encoded, decoded}], bytes in hexadecimal.
// Runs the package's own test file with a decoder that writes down what it is asked, so that
// its assertions hold for what is printed.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { MeshoptDecoder } from "meshoptimizer/decoder";

/** The package's test, which imports the decoder and runs by itself. */
const file = join(dirname(createRequire(import.meta.url).resolve("meshoptimizer")), "meshopt_decoder.test.js");
const IMPORT = "import { MeshoptDecoder as decoder } from './meshopt_decoder.mjs';";
const RUN = "tests[key]();";

const hex = (bytes) => Buffer.from(bytes).toString("hex");
const vectors = [];
let name = "";

function record(mode, target, count, stride, source, filter) {
  vectors.push({
    name,
    mode,
    filter: filter ?? "NONE",
    count,
    stride,
    encoded: hex(source),
    decoded: hex(target),
  });
}

globalThis.recorder = {
  ready: MeshoptDecoder.ready,
  begin: (key) => (name = key),
  decodeVertexBuffer(target, count, stride, source, filter) {
    MeshoptDecoder.decodeVertexBuffer(target, count, stride, source, filter);
    record("ATTRIBUTES", target, count, stride, source, filter);
  },
  decodeIndexBuffer(target, count, stride, source) {
    MeshoptDecoder.decodeIndexBuffer(target, count, stride, source);
    record("TRIANGLES", target, count, stride, source);
  },
  decodeIndexSequence(target, count, stride, source) {
    MeshoptDecoder.decodeIndexSequence(target, count, stride, source);
    record("INDICES", target, count, stride, source);
  },
  decodeGltfBuffer(target, count, stride, source, mode, filter) {
    MeshoptDecoder.decodeGltfBuffer(target, count, stride, source, mode, filter);
    record(mode, target, count, stride, source, filter);
  },
  async decodeGltfBufferAsync(count, stride, source, mode, filter) {
    const target = await MeshoptDecoder.decodeGltfBufferAsync(count, stride, source, mode, filter);
    record(mode, target, count, stride, source, filter);
    return target;
  },
};

const text = await readFile(file, "utf8");
if (!text.includes(IMPORT) || !text.includes(RUN)) {
  console.error(`${file} is not as expected`);
  process.exit(1);
}
const run = text.replace(IMPORT, "const decoder = recorder;").replace(RUN, `decoder.begin(key); ${RUN}`);
// The package counts its tests on standard output, which is ours here.
const log = console.log;
console.log = () => {};
await MeshoptDecoder.ready;
await import(`data:text/javascript,${encodeURIComponent(run)}`);
await new Promise((done) => setImmediate(done));
console.log = log;
console.log(JSON.stringify(vectors, null, 1));
