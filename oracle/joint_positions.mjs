// Plays a clip with three.js: `node joint_positions.mjs FILE CLIP TIME...`.
// CLIP is the index of the animation in the file, or `rest`; each TIME is in seconds and clamped
// to the clip. Prints {clip, duration_secs, nodes, frames: [{time_secs, positions}]} where
// `nodes` are the names in the file and `positions` the world positions by node index, null for
// a node outside the scene. Pictures are left out, so no browser is needed.

import { AnimationMixer, LoopOnce } from "three";
import { openScene } from "./scene.mjs";

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
const { document, gltf, nodes } = await openScene(file);
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
