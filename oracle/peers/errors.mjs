// How far files are from their source in motion, and how large they are: `node errors.mjs [--skin SKIN] SOURCE FILE...`,
// judged by three.js. Prints a row for each file, {error_mm, height_mm, bytes, json, pictures, brotli, fault}.
//
// Vertices of the source, drawn at random, are followed through every clip at seeded random times; in a file without
// clips, through every morph target at its full weight. An optimiser may reorder, weld and join vertices, so that a
// vertex of the source is followed by that of the file which is nearest at rest; where several are about as near (seams),
// by the one that stays nearest. The error is the greatest distance of any. Of files of clips alone the clips are played by
// the character SKIN, whose joints three.js finds by name.

import { Vector3 } from "three";
import { random } from "../random.mjs";
import { atRest, everyVertex, load, place, poses, rows } from "./judge.mjs";

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

const before = await load(source, skin);
const shown = poses(before, { count: POSES, fewest: FEWEST_POSES, seed: SEED });
const wanted = followed(before, shown);
console.log(JSON.stringify(await rows(files, wanted.height, skin, (scene) => greatestError(scene, shown, wanted))));
