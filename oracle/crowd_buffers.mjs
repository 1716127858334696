// Reads the buffers of a crowd by docs/formats/crowd-buffers.md alone: `node crowd_buffers.mjs DIR`.
//
// Prints {form, entries: [{joint, inverse_bind}], characters: [{character, level, source, matrices,
// morph_weights, world}]}, one character for each draw, then for each record, then for each stepped draw; `source`
// says which of these. `matrices` has the twelve numbers of each entry of the character's level, row by row, blended
// for a record; `morph_weights` is null without a set.
// Ends with 1 if the buffers contradict the page, 2 on wrong usage.

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const FILES = ["palettes", "draws", "records", "stepped", "cached", "morph_weights", "transforms", "vertices", "triangles"];

/** Bytes of a matrix, by form. */
export const MATRIX_BYTES = { matrix: 48, half: 24, rigid: 32, "half-rigid": 16 };

function ensure(holds, what) {
  if (!holds) throw new Error(what);
}

/** The manifest and the bytes of each file of a folder, by name without ending. */
export function readFolder(folder) {
  const manifest = JSON.parse(readFileSync(join(folder, "crowd.json"), "utf8"));
  const bytes = (name) => new Uint8Array(readFileSync(join(folder, `${name}.bin`)));
  return { manifest, files: Object.fromEntries(FILES.map((name) => [name, bytes(name)])) };
}

/** The number that a half stands for. */
export function half(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const [exponent, fraction] = [(bits >> 10) & 31, bits & 1023];
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  return sign * (1024 + fraction) * 2 ** (exponent - 25);
}

/** Rows of the rotation by a quaternion of any length, and of a translation. */
function ofQuaternion([x, y, z, w], [tx, ty, tz]) {
  const length = Math.hypot(x, y, z, w);
  const [a, b, c, d] = [x / length, y / length, z / length, w / length];
  // The image of a point p is p + 2 d (v × p) + 2 v × (v × p).
  const image = (p) => {
    const v = [a, b, c];
    const cross = (m, n) => [m[1] * n[2] - m[2] * n[1], m[2] * n[0] - m[0] * n[2], m[0] * n[1] - m[1] * n[0]];
    const once = cross(v, p);
    const twice = cross(v, once);
    return p.map((value, i) => value + 2 * d * once[i] + 2 * twice[i]);
  };
  const columns = [image([1, 0, 0]), image([0, 1, 0]), image([0, 0, 1]), [tx, ty, tz]];
  return [0, 1, 2].flatMap((row) => columns.map((column) => column[row]));
}

/** Reads matrices of one form. */
function matrixReader(form, bytes) {
  const size = MATRIX_BYTES[form];
  ensure(bytes.length % size === 0, `${bytes.length} bytes are no whole number of matrices`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const isHalf = form.startsWith("half");
  const number = (at) => (isHalf ? half(view.getUint16(at, true)) : view.getFloat32(at, true));
  const step = isHalf ? 2 : 4;
  return (index) => {
    ensure(index * size + size <= bytes.length, `there is no matrix ${index}`);
    const numbers = Array.from({ length: size / step }, (_, i) => number(index * size + i * step));
    if (!form.endsWith("rigid")) return numbers;
    ensure(numbers[7] === 1, `matrix ${index} does not end with 1`);
    return ofQuaternion(numbers.slice(0, 4), numbers.slice(4, 7));
  };
}

/** Calls `each(index, level)` for all elements of the groups, which must follow each other. */
function eachOf(list, each) {
  let next = 0;
  let lastLevel = -1;
  for (const { level, first, count } of list.groups) {
    ensure(first === next && count > 0, "groups must follow each other and not be empty");
    ensure(level > lastLevel, "groups must be in the order of the levels");
    lastLevel = level;
    next = first + count;
    for (let index = first; index < next; index += 1) each(index, level);
  }
  ensure(next === list.count, `the groups have ${next} of ${list.count} elements`);
}

function check(manifest, files) {
  ensure(manifest.format === "articula-crowd-buffers", `the format is ${manifest.format}`);
  ensure(manifest.version === 2, `version ${manifest.version} is unknown`);
  ensure(manifest.form in MATRIX_BYTES, `the form ${manifest.form} is unknown`);
  const size = MATRIX_BYTES[manifest.form];
  const sets = [manifest.draws, manifest.records, manifest.stepped].map((list) => list.with_morph_sets);
  const last = manifest.levels.at(-1);
  const expected = {
    palettes: manifest.palette_matrices * size,
    draws: manifest.draws.count * 8,
    records: manifest.records.count * 16,
    stepped: manifest.stepped.count * 8,
    cached: manifest.cached_matrices * size,
    morph_weights: (sets[0] + sets[1] + sets[2]) * manifest.morph_targets * 4,
    transforms: manifest.characters * 48,
    vertices: last.vertices_at + last.vertices * last.vertex_bytes,
    triangles: last.triangles_at + last.triangles * 12,
  };
  for (const name of FILES) {
    const stated = manifest.bytes[`${name}.bin`];
    ensure(files[name].length === stated, `${name}: ${files[name].length} bytes, the manifest states ${stated}`);
    ensure(stated === expected[name], `${name}: ${stated} bytes, the counts give ${expected[name]}`);
  }
  ensure(
    manifest.draws.first_morph_set === 0 &&
      manifest.records.first_morph_set === sets[0] &&
      manifest.stepped.first_morph_set === sets[0] + sets[1],
    "sets of draws come first, then those of records, then those of stepped draws",
  );
}

/** The matrices, weights and world transform of every shown character. */
export function decode({ manifest, files }) {
  check(manifest, files);
  const view = (name) => new DataView(files[name].buffer, files[name].byteOffset, files[name].byteLength);
  const [draws, records, stepped, weights] = ["draws", "records", "stepped", "morph_weights"].map(view);
  const palette = matrixReader(manifest.form, files.palettes);
  const cached = matrixReader(manifest.form, files.cached);
  const world = matrixReader("matrix", files.transforms);
  const seen = new Set();
  const characters = [];

  const weightsOf = (list, index) => {
    if (index >= list.with_morph_sets) return null;
    const set = list.first_morph_set + index;
    const weight = (_, i) => weights.getFloat32(4 * (set * manifest.morph_targets + i), true);
    return Array.from({ length: manifest.morph_targets }, weight);
  };
  const add = (source, index, level, character, entry) => {
    const list = { draw: manifest.draws, record: manifest.records, stepped: manifest.stepped }[source];
    ensure(character < manifest.characters, `there is no character ${character}`);
    ensure(!seen.has(character), `character ${character} is shown twice`);
    seen.add(character);
    characters.push({
      character,
      level,
      source,
      matrices: Array.from({ length: manifest.levels[level].matrices }, (_, e) => entry(e)),
      morph_weights: weightsOf(list, index),
      world: world(character),
    });
  };

  const drawn = (source, list, words, matrix) =>
    eachOf(list, (index, level) => {
      const [character, first] = [words.getUint32(8 * index, true), words.getUint32(8 * index + 4, true)];
      add(source, index, level, character, (e) => matrix(first + e));
    });
  drawn("draw", manifest.draws, draws, palette);
  eachOf(manifest.records, (index, level) => {
    const [before, after] = [records.getUint32(16 * index, true), records.getUint32(16 * index + 4, true)];
    const blend = records.getFloat32(16 * index + 8, true);
    ensure(blend >= 0 && blend <= 1, `record ${index} blends by ${blend}`);
    add("record", index, level, records.getUint32(16 * index + 12, true), (e) => {
      const b = cached(after + e);
      return cached(before + e).map((a, i) => a + (b[i] - a) * blend);
    });
  });
  drawn("stepped", manifest.stepped, stepped, cached);
  return characters;
}

/** Vertices and triangles of a level: [{position, normal, texcoord, influences: [{entry, weight}]}], [[a, b, c]]. */
export function meshOf({ manifest, files }, level) {
  const { vertices_at, vertices, vertex_bytes, influences, triangles_at, triangles, matrices } = manifest.levels[level];
  ensure(vertex_bytes === 32 + 6 * influences && influences % 4 === 0, "a vertex has another size");
  const { buffer, byteOffset } = files.vertices;
  const view = new DataView(buffer, byteOffset);
  const vertex = (_, v) => {
    const at = vertices_at + v * vertex_bytes;
    const floats = (from, count) => Array.from({ length: count }, (_, i) => view.getFloat32(at + from + 4 * i, true));
    const weights = floats(32 + 2 * influences, influences);
    const influence = (weight, i) => ({ entry: view.getUint16(at + 32 + 2 * i, true), weight });
    const all = weights.map(influence);
    ensure(all.every(({ entry }) => entry < matrices), `vertex ${v} has an entry that its level lacks`);
    return { position: floats(0, 3), normal: floats(12, 3), texcoord: floats(24, 2), influences: all };
  };
  const corners = new DataView(files.triangles.buffer, files.triangles.byteOffset);
  const corner = (t) => (_, i) => corners.getUint32(triangles_at + 12 * t + 4 * i, true);
  return {
    vertices: Array.from({ length: vertices }, vertex),
    triangles: Array.from({ length: triangles }, (_, t) => Array.from({ length: 3 }, corner(t))),
  };
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? "").href) {
  const [folder] = process.argv.slice(2);
  if (!folder) {
    console.error("usage: node crowd_buffers.mjs DIR");
    process.exit(2);
  }
  try {
    const all = readFolder(folder);
    const characters = decode(all);
    all.manifest.levels.forEach((_, level) => meshOf(all, level));
    const { form, entries } = all.manifest;
    console.log(JSON.stringify({ form, entries, characters }));
  } catch (error) {
    console.error(String(error.message ?? error));
    process.exit(1);
  }
}
