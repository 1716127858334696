// How far files are from their source in motion, and how large they are: `node errors.mjs [--skin SKIN] SOURCE FILE...`,
// judged by three.js. Prints a row for each file, {error_mm, height_mm, bytes, pictures, brotli, fault}.
//
// Vertices of the source, drawn at random, are followed through every clip at seeded random times; in a file without
// clips, through every morph target at its full weight. An optimiser may reorder, weld and join vertices, so that a
// vertex of the source is followed by that of the file which is nearest at rest; where several are about as near (seams),
// by the one that stays nearest. The error is the greatest distance of any. Of files of clips alone the clips are played by
// the character SKIN, whose joints three.js finds by name.

import { readFile } from "node:fs/promises";
import { brotliCompressSync, constants } from "node:zlib";
import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { random } from "../random.mjs";
import { openScene } from "../scene.mjs";

const words = process.argv.slice(2);
const skin = words[0] === "--skin" ? words.splice(0, 2)[1] : null;
const [source, ...files] = words;
if (files.length === 0) {
  console.error("usage: node errors.mjs [--skin SKIN] SOURCE FILE...");
  process.exit(2);
}

/** Vertices followed, poses of all clips together, and the fewest of one clip. */
const VERTICES = 3000;
const POSES = 400;
const FEWEST_POSES = 5;
/** Vertices are about as near if this part of the height does not tell them apart. */
const ABOUT = 2e-4;
const MOST_CANDIDATES = 24;
const SEED = 1123;

async function load(path) {
  const { animations, scene: own } = (await openScene(path)).gltf;
  // Tracks of nodes without a name find them in the scene that they were loaded with.
  const scene = skin ? (await openScene(skin)).gltf.scene : own;
  const meshes = [];
  scene.traverse((mesh) => mesh.isMesh && meshes.push(mesh));
  return { scene, animations, meshes, mixer: new AnimationMixer(scene) };
}

function atRest({ scene, meshes, mixer }) {
  mixer.stopAllAction();
  scene.updateMatrixWorld(true);
  for (const mesh of meshes) {
    mesh.skeleton?.update();
  }
}

/** The clip of a name; where the file has another name for it, the one at its place. */
function clipOf({ animations }, wanted, index) {
  return animations.find(({ name }) => name === wanted.name) ?? animations[index];
}

function play({ scene, mixer }, clip, time) {
  mixer.stopAllAction();
  if (clip) {
    const action = mixer.clipAction(clip);
    action.setLoop(LoopOnce, 1);
    action.clampWhenFinished = true;
    action.reset().play();
    mixer.setTime(0);
    mixer.update(Math.min(time, clip.duration));
  }
  scene.updateMatrixWorld(true);
}

const at = new Vector3();
function place([mesh, vertex], out) {
  mesh.getVertexPosition(vertex, at).applyMatrix4(mesh.matrixWorld);
  return out ? out.copy(at) : at.clone();
}

function everyVertex({ meshes }) {
  return meshes.flatMap((mesh) =>
    Array.from({ length: mesh.geometry.attributes.position.count }, (_, vertex) => [mesh, vertex]),
  );
}

/** Poses of a scene: for each, a function that shows it in any file. */
function poses({ animations, meshes }) {
  const next = random(SEED);
  const each = Math.max(FEWEST_POSES, Math.ceil(POSES / Math.max(animations.length, 1)));
  const ofClips = animations.flatMap((clip, index) =>
    Array.from({ length: each }, () => {
      const time = clip.duration * next();
      return (scene) => play(scene, clipOf(scene, clip, index), time);
    }),
  );
  const count = Math.max(0, ...meshes.map((mesh) => mesh.morphTargetInfluences?.length ?? 0));
  const ofTargets = Array.from({ length: animations.length > 0 ? 0 : count }, (_, target) => (scene) => {
    for (const mesh of scene.meshes) {
      mesh.morphTargetInfluences?.forEach((_, i, all) => (all[i] = i === target ? 1 : 0));
    }
  });
  return [...ofClips, ...ofTargets];
}

/** Positions of the followed vertices of the source at rest and in every pose. */
function followed(scene, shown) {
  const next = random(SEED + 1);
  atRest(scene);
  const all = everyVertex(scene);
  const heights = all.map((vertex) => place(vertex).y);
  const height = heights.reduce((a, b) => Math.max(a, b)) - heights.reduce((a, b) => Math.min(a, b));
  const chosen = Array.from({ length: Math.min(VERTICES, all.length) }, () => all[Math.floor(next() * all.length)]);
  const rest = chosen.map((vertex) => place(vertex));
  const moved = shown.map((show) => {
    show(scene);
    return chosen.map((vertex) => place(vertex));
  });
  return { height, rest, moved };
}

/** Vertices of a file that are nearest to each point at rest. */
function candidates(all, points, height) {
  const places = all.map((vertex) => place(vertex));
  const squares = new Float64Array(all.length);
  return points.map((point) => {
    let nearest = Infinity;
    for (let i = 0; i < squares.length; i++) {
      squares[i] = places[i].distanceToSquared(point);
      nearest = Math.min(nearest, squares[i]);
    }
    const most = (Math.sqrt(nearest) + ABOUT * height) ** 2;
    const near = [];
    squares.forEach((square, i) => square <= most && near.push(i));
    near.sort((a, b) => squares[a] - squares[b]);
    return near.slice(0, MOST_CANDIDATES).map((i) => all[i]);
  });
}

function greatestError(scene, shown, { height, rest, moved }) {
  atRest(scene);
  const near = candidates(everyVertex(scene), rest, height);
  const worst = near.map((vertices, v) => vertices.map((vertex) => place(vertex).distanceTo(rest[v])));
  const out = new Vector3();
  shown.forEach((show, pose) => {
    show(scene);
    near.forEach((vertices, v) =>
      vertices.forEach((vertex, c) => {
        worst[v][c] = Math.max(worst[v][c], place(vertex, out).distanceTo(moved[pose][v]));
      }),
    );
  });
  return Math.max(...worst.map((of) => Math.min(...of)));
}

/** Bytes of a GLB without its pictures, which no contestant changes, and of the pictures. */
async function parts(file) {
  const bytes = await readFile(file);
  const length = bytes.readUInt32LE(12);
  const document = JSON.parse(bytes.subarray(20, 20 + length));
  const binary = 20 + length + 8;
  const views = (document.images ?? []).map(({ bufferView }) => document.bufferViews?.[bufferView]);
  const cuts = views.filter(Boolean).map(({ byteOffset = 0, byteLength }) => [binary + byteOffset, byteLength]);
  const unlike = new Map(cuts);
  let [kept, from] = [[], 0];
  for (const [start, size] of [...unlike].sort(([a], [b]) => a - b)) {
    kept.push(bytes.subarray(from, start));
    from = start + size;
  }
  const rest = Buffer.concat([...kept, bytes.subarray(from)]);
  const params = { [constants.BROTLI_PARAM_QUALITY]: 11, [constants.BROTLI_PARAM_LGWIN]: 22 };
  return { bytes: rest.length, pictures: bytes.length - rest.length, brotli: brotliCompressSync(rest, { params }).length };
}

const before = await load(source);
const shown = poses(before);
const wanted = followed(before, shown);
const height_mm = 1e3 * wanted.height;
const rows = [];
for (const file of files) {
  const sizes = await parts(file);
  try {
    const error_mm = 1e3 * greatestError(await load(file), shown, wanted);
    rows.push({ error_mm, height_mm, ...sizes, fault: null });
  } catch (error) {
    rows.push({ error_mm: null, height_mm, ...sizes, fault: String(error.message ?? error).split("\n")[0] });
  }
}
console.log(JSON.stringify(rows));
