// A glTF file as three.js loads it, without pictures, so that no browser is needed.

import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";
import { MeshoptDecoder } from "meshoptimizer/decoder";

// The loader expects a browser's global names.
globalThis.self ??= globalThis;
globalThis.ProgressEvent ??= class extends Event {};

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
    // A buffer without bytes stands for what compressed views hold.
    const isEmpty = !buffer.uri && buffers.length > 0;
    if (buffer.uri?.startsWith("data:") || isEmpty) {
      buffers.push(buffer);
      continue;
    }
    const bytes = buffer.uri ? await readFile(resolve(folder, decodeURIComponent(buffer.uri))) : binary;
    const base64 = Buffer.from(bytes).toString("base64");
    buffers.push({ ...buffer, uri: `data:application/octet-stream;base64,${base64}` });
  }
  return { ...document, buffers };
}

/** Document, and the text of one with every buffer in it and no pictures. */
export async function readAsText(file) {
  const { document, binary } = open(new Uint8Array(await readFile(file)));
  const whole = await withBuffers(withoutPictures(document), binary, dirname(file));
  // Loaders know one of the two names of the same compression.
  const json = JSON.stringify(whole).replaceAll("KHR_meshopt_compression", "EXT_meshopt_compression");
  return { document, json };
}

/** Document, loaded scene with its animations, and the object of every node. */
export async function openScene(file) {
  const { document, json } = await readAsText(file);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  const gltf = await loader.parseAsync(json, "");
  const count = document.nodes?.length ?? 0;
  const nodes = await Promise.all(
    Array.from({ length: count }, (_, index) => gltf.parser.getDependency("node", index)),
  );
  return { document, gltf, nodes };
}
