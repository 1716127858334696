// How far Babylon.js shows the vertices of files from where three.js has them: `node babylon.mjs FILE…`.
// Every vertex is compared at rest and in seeded random poses of all clips and morph targets, so that what one of them
// reads of compressed and rounded arrays the other does too. Prints one JSON row for each file, [{apart_mm, fault}].

import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { SceneLoader } from "@babylonjs/core/Loading/sceneLoader.js";
import { Vector3 } from "@babylonjs/core/Maths/math.vector.js";
import { MeshoptCompression } from "@babylonjs/core/Meshes/Compression/meshoptCompression.js";
import { Logger } from "@babylonjs/core/Misc/logger.js";
import { Scene } from "@babylonjs/core/scene.js";
import "@babylonjs/core/Animations/animatable.js";
import "@babylonjs/loaders/glTF/2.0/index.js";
import { MeshoptDecoder } from "meshoptimizer/decoder";
import { random } from "../random.mjs";
import { readAsText } from "../scene.mjs";
import { load, place, play } from "./judge.mjs";

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node babylon.mjs FILE…");
  process.exit(2);
}

/** Poses of each clip. */
const POSES = 3;
/** Frames in a second of the loader's clips. */
const FPS = 60;

await MeshoptDecoder.ready;
// The decoder that it would fetch.
MeshoptCompression._Default = {
  decodeGltfBufferAsync: (source, count, stride, mode, filter) =>
    MeshoptDecoder.decodeGltfBufferAsync(count, stride, source, mode, filter),
};

/** A file as Babylon.js loads it, and its nodes at rest. */
async function loadByBabylon(path) {
  const { json } = await readAsText(path);
  const scene = new Scene(new NullEngine());
  scene.useRightHandedSystem = true;
  await SceneLoader.AppendAsync("", `data:${json}`, scene, undefined, ".gltf");
  scene.animationGroups.forEach((group) => group.stop());
  const nodes = [...scene.transformNodes, ...scene.meshes];
  const rest = nodes.map((node) => ({
    node,
    position: node.position.clone(),
    rotation: node.rotationQuaternion?.clone(),
    scaling: node.scaling.clone(),
  }));
  const meshes = scene.meshes.filter((mesh) => mesh.getTotalVertices() > 0);
  const influences = meshes.map(({ morphTargetManager: targets }) => targetsOf(targets).map((t) => t.influence));
  return { scene, meshes, rest, influences };
}

function targetsOf(manager) {
  return Array.from({ length: manager?.numTargets ?? 0 }, (_, i) => manager.getTarget(i));
}

/** Shows a scene of Babylon.js at a time of a clip, which moves what it has channels for; at rest without one. */
function playByBabylon({ scene, meshes, rest, influences }, clip, time) {
  for (const { node, position, rotation, scaling } of rest) {
    node.position.copyFrom(position);
    node.rotationQuaternion?.copyFrom(rotation);
    node.scaling.copyFrom(scaling);
  }
  meshes.forEach((mesh, m) => {
    targetsOf(mesh.morphTargetManager).forEach((target, i) => (target.influence = influences[m][i]));
  });
  const group = scene.animationGroups[clip];
  if (group) {
    group.start(false);
    group.pause();
    group.goToFrame(Math.min(time * FPS, group.to));
    group.stop(true);
  }
}

/** Places of all vertices of a mesh of Babylon.js in the pose of the moment. */
function placesByBabylon(mesh) {
  mesh.skeleton?.prepare(true);
  const world = mesh.computeWorldMatrix(true);
  const positions = mesh.getPositionData(true, true);
  return Array.from({ length: positions.length / 3 }, (_, vertex) =>
    Vector3.TransformCoordinates(Vector3.FromArray(positions, 3 * vertex), world),
  );
}

/** The greatest distance between the two loaders' vertices in metres, in the pose of the moment. */
function apart(three, babylon) {
  let most = 0;
  three.meshes.forEach((mesh, m) => {
    mesh.skeleton?.update();
    placesByBabylon(babylon.meshes[m]).forEach(({ x, y, z }, vertex) => {
      const wanted = place([mesh, vertex]);
      const far = Math.hypot(wanted.x - x, wanted.y - y, wanted.z - z);
      most = far <= most ? most : far;
    });
  });
  return most;
}

/** Sets one morph target of all meshes of both to its full weight, or none. */
function blend(three, babylon, target) {
  three.meshes.forEach((mesh) => mesh.morphTargetInfluences?.forEach((_, i, all) => (all[i] = i === target ? 1 : 0)));
  babylon.meshes.forEach((mesh) => {
    targetsOf(mesh.morphTargetManager).forEach((of, i) => (of.influence = i === target ? 1 : 0));
  });
}

/** The greatest distance in metres in any pose. */
async function farthest(path) {
  const [three, babylon] = [await load(path), await loadByBabylon(path)];
  const counts = [three.meshes.map((m) => m.geometry.attributes.position.count), babylon.meshes.map((m) => m.getTotalVertices())];
  if (String(counts[0]) !== String(counts[1])) {
    throw new Error(`vertices: ${counts[0]} in three.js, ${counts[1]} in Babylon.js`);
  }
  const next = random(1);
  const poses = three.animations.flatMap((clip, index) =>
    Array.from({ length: POSES }, () => ({ clip, index, time: clip.duration * next() })),
  );
  let most = 0;
  for (const { clip, index, time } of [{}, ...poses]) {
    play(three, clip, time);
    playByBabylon(babylon, index, time);
    most = Math.max(most, apart(three, babylon));
  }
  play(three, null, 0);
  playByBabylon(babylon, -1, 0);
  const targets = Math.max(0, ...three.meshes.map((mesh) => mesh.morphTargetInfluences?.length ?? 0));
  for (let target = 0; target < targets; target++) {
    blend(three, babylon, target);
    most = Math.max(most, apart(three, babylon));
  }
  babylon.scene.dispose();
  return most;
}

// What it tells of itself belongs to no report.
Logger.LogLevels = Logger.ErrorLogLevel;
const rows = [];
for (const file of files) {
  try {
    rows.push({ apart_mm: 1e3 * (await farthest(file)), fault: null });
  } catch (error) {
    rows.push({ apart_mm: null, fault: String(error.message ?? error).split("\n")[0] });
  }
}
console.log(JSON.stringify(rows));
process.exit(0);
