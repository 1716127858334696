// Drives a portrait by its player, without a browser: node portrait.mjs player.js < job
//
// The job is `{"json": document, "inputs": [input of ArticulaPortrait.drive, …]}`. Prints for each input
// `{"pose": angles, "weights": those of the expressions, "places": x and y of each vertex, "missing": names}`.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { resolve } from "node:path";

const require = createRequire(import.meta.url);
const { ArticulaPortrait } = require(resolve(process.argv[2]));
const { json, inputs } = JSON.parse(readFileSync(0, "utf8"));

/** A canvas on which nothing is seen. */
const context = new Proxy({}, { get: (_, name) => (name === "createPattern" ? () => null : () => {}), set: () => true });
globalThis.cancelAnimationFrame = () => {};

const face = new ArticulaPortrait({ getContext: () => context }, json, []);
const shown = inputs.map((input) => {
  const missing = face.drive(input);
  const { pose, weights } = face.driven;
  return { pose, weights, places: [...face.places(pose, weights)], missing };
});
process.stdout.write(JSON.stringify(shown));
