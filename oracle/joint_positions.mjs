// Plays a clip with three.js: `node joint_positions.mjs FILE CLIP TIME...`.
// CLIP is the index of the animation in the file, or `rest`; each TIME is in seconds and clamped
// to the clip. Prints {clip, duration_secs, nodes, frames: [{time_secs, positions}]} where
// `nodes` are the names in the file and `positions` the world positions by node index, null for
// a node outside the scene. Pictures are left out, so no browser is needed.

import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";

// The loader expects a browser's global names.
globalThis.self ??= globalThis;
globalThis.ProgressEvent ??= class extends Event {};

const { AnimationMixer, LoopOnce } = await import("three");
const { GLTFLoader } = await import("three/addons/loaders/GLTFLoader.js");

const GLB_MAGIC = 0x46546c67;
const CHUNK_JSON = 0x4e4f534a;

/** Document and binary chunk (or null) of a GLB or glTF file. */
function open(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (view.getUint32(0, true) !== GLB_MAGIC) {
    return { document: JSON.parse(new TextDecoder().decode(bytes)), binary: null };
  }
  const chunks = [];
  for (let at = 12; at + 8 <= bytes.length; ) {
    const length = view.getUint32(at, true);
    chunks.push({ kind: view.getUint32(at + 4, true), bytes: bytes.subarray(at + 8, at + 8 + length) });
    at += 8 + length;
  }
  const json = chunks.find((chunk) => chunk.kind === CHUNK_JSON);
  return {
    document: JSON.parse(new TextDecoder().decode(json.bytes)),
    binary: chunks.find((chunk) => chunk.kind !== CHUNK_JSON)?.bytes ?? null,
  };
}

/** Takes pictures and looks out of the document: decoding them needs a browser. */
function withoutPictures(document) {
  const { images, textures, samplers, ...rest } = document;
  return { ...rest, materials: document.materials?.map(({ name }) => ({ name })) };
}

/** Puts every buffer into the document, so that the loader fetches nothing. */
async function withBuffers(document, binary, folder) {
  const buffers = [];
  for (const buffer of document.buffers ?? []) {
    if (buffer.uri?.startsWith("data:")) {
      buffers.push(buffer);
      continue;
    }
    const bytes = buffer.uri ? await readFile(resolve(folder, decodeURIComponent(buffer.uri))) : binary;
    const base64 = Buffer.from(bytes).toString("base64");
    buffers.push({ ...buffer, uri: `data:application/octet-stream;base64,${base64}` });
  }
  return { ...document, buffers };
}

/** World position of every node that hangs in the scene. */
function worldPositions(scene, nodes) {
  scene.updateMatrixWorld(true);
  const shown = new Set();
  scene.traverse((object) => shown.add(object));
  return nodes.map((node) => (shown.has(node) ? node.matrixWorld.elements.slice(12, 15) : null));
}

/** World positions at each time, every time played from the clip's beginning. */
function play(scene, nodes, clip, times) {
  if (!clip) {
    return [{ time_secs: 0, positions: worldPositions(scene, nodes) }];
  }
  const mixer = new AnimationMixer(scene);
  const action = mixer.clipAction(clip);
  action.setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  return times.map((time) => {
    action.reset().play();
    mixer.update(time);
    return { time_secs: time, positions: worldPositions(scene, nodes) };
  });
}

const [file, clipText, ...timeTexts] = process.argv.slice(2);
const times = timeTexts.map(Number);
const clipIndex = Number(clipText);
const usable = clipText === "rest" || (Number.isInteger(clipIndex) && times.length > 0);
if (!file || !usable || times.some((time) => !Number.isFinite(time))) {
  console.error("usage: node joint_positions.mjs FILE (CLIP_INDEX TIME... | rest)");
  process.exit(2);
}
const { document, binary } = open(new Uint8Array(await readFile(file)));
const whole = await withBuffers(withoutPictures(document), binary, dirname(file));
const gltf = await new GLTFLoader().parseAsync(JSON.stringify(whole), "");
const count = document.nodes?.length ?? 0;
const nodes = await Promise.all(
  Array.from({ length: count }, (_, index) => gltf.parser.getDependency("node", index)),
);
const clip = clipText === "rest" ? null : gltf.animations[clipIndex];
if (clip === undefined) {
  console.error(`${file} has ${gltf.animations.length} clips, not one of index ${clipIndex}`);
  process.exit(1);
}
console.log(
  JSON.stringify({
    clip: clip?.name ?? null,
    duration_secs: clip?.duration ?? 0,
    nodes: (document.nodes ?? []).map((node) => node.name ?? ""),
    frames: play(gltf.scene, nodes, clip, times),
  }),
);
