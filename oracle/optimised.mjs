// How far an optimised file is from its source, judged by three.js: `node optimised.mjs SOURCE FILE MM`.
// Each clip is played at seeded random times. Of random points of the surface of either file the distance to the
// surface of the other is measured: no more than the error that was stated, of vertices and of the surface. So are
// the distances of all nodes of the same name. Prints one JSON row for each clip, {clip, surface_mm, nodes_mm}. Ends
// with status 1 if one exceeds MM.

import { AnimationMixer, LoopOnce, Triangle, Vector3 } from "three";
import { random } from "./random.mjs";
import { openScene } from "./scene.mjs";

const [source, file, bound] = process.argv.slice(2);
if (!bound) {
  console.error("usage: node optimised.mjs SOURCE FILE MM");
  process.exit(2);
}

const TIMES = 6;
const POINTS = 150;

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

/** Triangles of all meshes in world space, one list for each, with a sphere around each triangle. */
function surfaces({ gltf }) {
  const all = [];
  gltf.scene.traverse((mesh) => {
    if (!mesh.isMesh) {
      return;
    }
    const { position } = mesh.geometry.attributes;
    const place = (_, i) => mesh.getVertexPosition(i, new Vector3()).applyMatrix4(mesh.matrixWorld);
    const vertices = Array.from({ length: position.count }, place);
    const corners = mesh.geometry.index?.array ?? vertices.map((_, i) => i);
    const triangles = Array.from({ length: Math.floor(corners.length / 3) }, (_, i) => {
      const [a, b, c] = [0, 1, 2].map((k) => vertices[corners[3 * i + k]]);
      const triangle = new Triangle(a, b, c);
      const centre = triangle.getMidpoint(new Vector3());
      const radius = Math.max(...[a, b, c].map((corner) => corner.distanceTo(centre)));
      return { triangle, centre, radius };
    });
    all.push(triangles);
  });
  return all;
}

/** Distance of a point to the nearest triangle. */
function distance(point, triangles) {
  let least = Infinity;
  const near = new Vector3();
  for (const { triangle, centre, radius } of triangles) {
    if (centre.distanceTo(point) - radius < least) {
      // Not a number where rounding left a triangle no area; its points are those of its neighbours' edges.
      const apart = triangle.closestPointToPoint(point, near).distanceTo(point);
      least = apart < least ? apart : least;
    }
  }
  return least;
}

/** A random point of a random triangle. */
function drawn(triangles, next) {
  const { a, b, c } = triangles[Math.floor(next() * triangles.length)].triangle;
  let [u, v] = [next(), next()];
  if (u + v > 1) {
    [u, v] = [1 - u, 1 - v];
  }
  return a.clone().multiplyScalar(1 - u - v).addScaledVector(b, u).addScaledVector(c, v);
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
  let [ofSurface, ofNodes] = [0, 0];
  for (let i = 0; i < TIMES; i++) {
    const time = duration * next();
    pose(before, name, time);
    pose(after, name, time);
    const [from, to] = [surfaces(before), surfaces(after)];
    if (from.length !== to.length) {
      throw new Error(`${from.length} meshes, but ${to.length} in the file`);
    }
    // The nearest surface may be that of another mesh.
    const sides = [
      [from.flat(), to.flat()],
      [to.flat(), from.flat()],
    ];
    for (const [own, other] of sides) {
      for (let p = 0; p < POINTS * from.length; p++) {
        ofSurface = Math.max(ofSurface, distance(drawn(own, next), other));
      }
    }
    const found = nodes(after);
    for (const [node, place] of nodes(before)) {
      ofNodes = Math.max(ofNodes, found.get(node)?.distanceTo(place) ?? Infinity);
    }
  }
  worst = Math.max(worst, ofSurface, ofNodes);
  console.log(JSON.stringify({ clip: name, surface_mm: 1e3 * ofSurface, nodes_mm: 1e3 * ofNodes }));
}
process.exit(1e3 * worst <= Number(bound) ? 0 : 1);
