// Drives a portrait by its player, without a browser: node portrait.mjs player.js < job
//
// The job is `{"json": document, "inputs": [input of ArticulaPortrait.drive, …]}`. Prints for each input
// `{"pose": angles, "weights": those of the expressions, "shown": those at the level, "reaches": how far each moves, "places": x and y of each vertex
// without a level, "missing": names}`. `"options"` are those of the constructor, `"css"` is the size of the canvas.
// With `"frames": [milliseconds, …]`, prints the level after each frame that took so long instead.
// With `"background": [{"from": seconds, "picture": name}, …]` and `"times": [seconds, …]` in the job, prints the name
// of the picture that is drawn at each time of the first clip instead; with `"planes": [angles, …]`, how each turns the
// canvas.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const require = createRequire(import.meta.url);
const { ArticulaPortrait } = require(resolve(process.argv[2]));
const { json, inputs, background = null, times, planes, options = {}, css = [400, 0], frames } = JSON.parse(readFileSync(0, "utf8"));

/** A canvas on which nothing is seen; what is drawn behind is kept. */
let behind = null;
const calls = { createPattern: () => null, drawImage: (picture) => (behind = picture) };
const context = new Proxy({}, { get: (_, name) => calls[name] ?? (() => {}), set: () => true });
const [clientWidth, clientHeight] = css;
const canvas = { getContext: () => context, clientWidth, clientHeight, style: {} };
globalThis.cancelAnimationFrame = () => {};

const face = new ArticulaPortrait(canvas, json, [], { background, ...options });
const drawnAt = (time) => {
  behind = null;
  face.seek(time);
  return behind;
};
const turned = (angles) => {
  face.turnPlane(angles);
  return canvas.style.transform;
};
const levelAfter = (milliseconds) => {
  face.judge(milliseconds);
  return face.level;
};
const shown = times?.map(drawnAt) ?? planes?.map(turned) ?? frames?.map(levelAfter) ?? inputs.map((input) => {
  const missing = face.drive(input);
  const { pose, weights } = face.driven;
  return { pose, weights, shown: face.shown, reaches: face.reaches, places: [...face.places(pose, weights)], missing };
});
process.stdout.write(JSON.stringify(shown));
