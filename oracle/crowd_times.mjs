// What a crowd costs in three.js: `node crowd_times.mjs FILE CLIP COUNT FRAMES ROUNDS`.
// Clones the file's scene COUNT times, plays the clip of that name with distinct phases, and
// prints {count, clip, joints, mixer, world, joint_matrices}: nanoseconds of processor time for
// each character and frame, as {median_ns, least_ns} over ROUNDS turns of FRAMES frames; `world`
// is mixer and world matrices, `joint_matrices` both and the matrices a GPU skins with.

import { AnimationMixer } from "three";
import { clone } from "three/addons/utils/SkeletonUtils.js";
import { openScene } from "./scene.mjs";

const SECS_PER_FRAME = 1 / 60;
// Frames before anything counts, for the compiler of the engine.
const WARM_UP_FRAMES = 60;

/** One character: its mixer, its root, and its skeletons. */
function character(scene, clip, phase) {
  const root = clone(scene);
  const mixer = new AnimationMixer(root);
  const action = mixer.clipAction(clip).play();
  action.time = phase * clip.duration;
  const skeletons = new Set();
  root.traverse((object) => object.isSkinnedMesh && skeletons.add(object.skeleton));
  return { root, mixer, skeletons: [...skeletons] };
}

const STEPS = {
  mixer: ({ mixer }) => mixer.update(SECS_PER_FRAME),
  world: ({ mixer, root }) => {
    mixer.update(SECS_PER_FRAME);
    root.updateMatrixWorld(true);
  },
  joint_matrices: ({ mixer, root, skeletons }) => {
    mixer.update(SECS_PER_FRAME);
    root.updateMatrixWorld(true);
    for (const skeleton of skeletons) {
      skeleton.update();
    }
  },
};

/** Processor time of the process so far. Its collector's threads count: they clean up after it. */
function processNs() {
  const { user, system } = process.cpuUsage();
  return (user + system) * 1000;
}

function turn(crowd, step, frames) {
  const start = processNs();
  for (let frame = 0; frame < frames; frame++) {
    crowd.forEach(step);
  }
  return (processNs() - start) / (frames * crowd.length);
}

function summary(times) {
  const sorted = [...times].sort((a, b) => a - b);
  const middle = sorted.length >> 1;
  const below = sorted.length % 2 === 0 ? middle - 1 : middle;
  return { median_ns: (sorted[below] + sorted[middle]) / 2, least_ns: sorted[0] };
}

const [file, clipName, ...numbers] = process.argv.slice(2);
const [count, frames, rounds] = numbers.map(Number);
if (!file || !clipName || ![count, frames, rounds].every((n) => Number.isInteger(n) && n > 0)) {
  console.error("usage: node crowd_times.mjs FILE CLIP COUNT FRAMES ROUNDS");
  process.exit(2);
}
const { gltf } = await openScene(file);
const clip = gltf.animations.find((animation) => animation.name === clipName);
if (!clip) {
  console.error(`${file} has no clip called ${clipName}`);
  process.exit(1);
}
// The golden ratio spreads any number of phases evenly.
const crowd = Array.from({ length: count }, (_, i) => character(gltf.scene, clip, (i * 0.6180339887) % 1));
for (let done = 0; done < WARM_UP_FRAMES; done++) {
  crowd.slice(0, 100).forEach(STEPS.joint_matrices);
}
const times = Object.fromEntries(Object.keys(STEPS).map((name) => [name, []]));
for (let round = 0; round < rounds; round++) {
  for (const [name, step] of Object.entries(STEPS)) {
    times[name].push(turn(crowd, step, frames));
  }
}
const joints = crowd[0].skeletons.reduce((sum, skeleton) => sum + skeleton.bones.length, 0);
const costs = Object.entries(times).map(([name, list]) => [name, summary(list)]);
console.log(JSON.stringify({ count, clip: clipName, joints, ...Object.fromEntries(costs) }));
