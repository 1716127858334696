// How far an optimised file is from its source, judged by three.js: `node optimised.mjs SOURCE FILE MM`.
// Each clip is played at seeded random times. Of vertices of the source, drawn at random, the distance to the
// nearest vertex of the file is measured: no more than that of the vertex that it became. So are the distances of
// all nodes of the same name. Prints one JSON row for each clip, {clip, vertices_mm, nodes_mm}. Ends with status 1
// if one exceeds MM.

import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { random } from "./random.mjs";
import { openScene } from "./scene.mjs";

const [source, file, bound] = process.argv.slice(2);
if (!bound) {
  console.error("usage: node optimised.mjs SOURCE FILE MM");
  process.exit(2);
}

const TIMES = 6;
const VERTICES = 150;

/** Poses the scene at a time of a clip, or at rest. */
function pose({ gltf, mixer }, name, time) {
  mixer.stopAllAction();
  const clip = gltf.animations.find((clip) => clip.name === name);
  if (clip) {
    const action = mixer.clipAction(clip);
    action.setLoop(LoopOnce, 1);
    action.clampWhenFinished = true;
    action.reset().play();
    mixer.update(time);
  }
  gltf.scene.updateMatrixWorld(true);
}

/** World positions of the vertices of all meshes, one list for each. */
function vertices({ gltf }) {
  const all = [];
  const at = new Vector3();
  gltf.scene.traverse((mesh) => {
    if (mesh.isMesh) {
      const { count } = mesh.geometry.attributes.position;
      const place = (_, i) => mesh.getVertexPosition(i, at).applyMatrix4(mesh.matrixWorld).clone();
      all.push(Array.from({ length: count }, place));
    }
  });
  return all;
}

function nodes({ gltf }) {
  const all = new Map();
  gltf.scene.traverse((node) => {
    if (node.name) {
      all.set(node.name, new Vector3().setFromMatrixPosition(node.matrixWorld));
    }
  });
  return all;
}

async function load(path) {
  const { gltf } = await openScene(path);
  return { gltf, mixer: new AnimationMixer(gltf.scene) };
}

const [before, after] = [await load(source), await load(file)];
const next = random(7);
let worst = 0;
const names = before.gltf.animations.map(({ name }) => name);
for (const name of names.length > 0 ? names : [null]) {
  const { duration } = before.gltf.animations.find((clip) => clip.name === name) ?? { duration: 0 };
  let [ofVertices, ofNodes] = [0, 0];
  for (let i = 0; i < TIMES; i++) {
    const time = duration * next();
    pose(before, name, time);
    pose(after, name, time);
    const [from, to] = [vertices(before), vertices(after)];
    if (from.length !== to.length) {
      throw new Error(`${from.length} meshes, but ${to.length} in the file`);
    }
    from.forEach((points, mesh) => {
      for (let v = 0; v < VERTICES; v++) {
        const point = points[Math.floor(next() * points.length)];
        const distances = to[mesh].map((other) => other.distanceToSquared(point));
        ofVertices = Math.max(ofVertices, Math.sqrt(Math.min(...distances)));
      }
    });
    const found = nodes(after);
    for (const [node, place] of nodes(before)) {
      ofNodes = Math.max(ofNodes, found.get(node)?.distanceTo(place) ?? Infinity);
    }
  }
  worst = Math.max(worst, ofVertices, ofNodes);
  console.log(JSON.stringify({ clip: name, vertices_mm: 1e3 * ofVertices, nodes_mm: 1e3 * ofNodes }));
}
process.exit(1e3 * worst <= Number(bound) ? 0 : 1);
