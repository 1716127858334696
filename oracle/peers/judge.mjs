// What the judges of optimised files share: a file as three.js plays it, poses to compare, and sizes.

import { readFile } from "node:fs/promises";
import { brotliCompressSync, constants } from "node:zlib";
import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { random } from "../random.mjs";
import { openScene } from "../scene.mjs";

/** A file, its clips and meshes; clips are played by the character `skin` if there is one. */
export async function load(path, skin = null) {
  const { animations, scene: own } = (await openScene(path)).gltf;
  // Tracks of nodes without a name find them in the scene that they were loaded with.
  const scene = skin ? (await openScene(skin)).gltf.scene : own;
  const meshes = [];
  scene.traverse((mesh) => mesh.isMesh && meshes.push(mesh));
  return { scene, animations, meshes, mixer: new AnimationMixer(scene) };
}

/** Shows a scene at rest. */
export function atRest({ scene, meshes, mixer }) {
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

/** Shows a scene at a time of a clip; at rest without one. */
export function play({ scene, mixer }, clip, time) {
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
/** A vertex in the pose of the moment. */
export function place([mesh, vertex], out) {
  mesh.getVertexPosition(vertex, at).applyMatrix4(mesh.matrixWorld);
  return out ? out.copy(at) : at.clone();
}

/** All vertices, as pairs of mesh and index. */
export function everyVertex({ meshes }) {
  return meshes.flatMap((mesh) =>
    Array.from({ length: mesh.geometry.attributes.position.count }, (_, vertex) => [mesh, vertex]),
  );
}

/**
 * Poses of a scene: for each, a function that shows it in any file. `count` of all clips together, at least `fewest` of
 * each, at seeded random times; without clips, every morph target at its full weight.
 */
export function poses({ animations, meshes }, { count, fewest, seed }) {
  const next = random(seed);
  const each = Math.max(fewest, Math.ceil(count / Math.max(animations.length, 1)));
  const ofClips = animations.flatMap((clip, index) =>
    Array.from({ length: each }, () => {
      const time = clip.duration * next();
      return (scene) => play(scene, clipOf(scene, clip, index), time);
    }),
  );
  const targets = Math.max(0, ...meshes.map((mesh) => mesh.morphTargetInfluences?.length ?? 0));
  const ofTargets = Array.from({ length: animations.length > 0 ? 0 : targets }, (_, target) => (scene) => {
    for (const mesh of scene.meshes) {
      mesh.morphTargetInfluences?.forEach((_, i, all) => (all[i] = i === target ? 1 : 0));
    }
  });
  return [...ofClips, ...ofTargets];
}

/** Bytes of a GLB without its pictures, which no contestant changes, of its JSON, and of the pictures. */
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
  const brotli = brotliCompressSync(rest, { params }).length;
  return { bytes: rest.length, json: length, pictures: bytes.length - rest.length, brotli };
}

/** Rows of files: `{error_mm, height_mm, bytes, json, pictures, brotli, fault}`, with the error in m by `errorOf(scene)`. */
export async function rows(files, height, skin, errorOf) {
  const height_mm = 1e3 * height;
  const all = [];
  for (const file of files) {
    const sizes = await parts(file);
    try {
      const error_mm = 1e3 * errorOf(await load(file, skin));
      all.push({ error_mm, height_mm, ...sizes, fault: null });
    } catch (error) {
      all.push({ error_mm: null, height_mm, ...sizes, fault: String(error.message ?? error).split("\n")[0] });
    }
  }
  return all;
}
