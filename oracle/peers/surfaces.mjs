// How far the surfaces of files are from that of their source in motion: `node surfaces.mjs SOURCE FILE...`, judged by
// three.js. Prints a row for each file, {error_mm, height_mm, bytes, json, pictures, brotli, fault}.
//
// For files with other triangles than their source, whose vertices cannot be followed. Both are shown at rest and in the same
// seeded random poses; the error is the greatest distance of a vertex of either from the surface of the other.

import { BufferAttribute, BufferGeometry, Vector3 } from "three";
import { MeshBVH } from "three-mesh-bvh";
import { random } from "../random.mjs";
import { atRest, everyVertex, load, place, poses, rows } from "./judge.mjs";

const [source, ...files] = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node surfaces.mjs SOURCE FILE...");
  process.exit(2);
}

/** Vertices of each file in a pose, and poses. */
const VERTICES = 3000;
const POSES = 20;
const SEED = 2311;

/** The vertices of all meshes in the pose of the moment, and their triangles. */
function posed({ meshes }) {
  const [positions, triangles] = [[], []];
  for (const mesh of meshes) {
    const first = positions.length / 3;
    const { index, attributes } = mesh.geometry;
    for (let vertex = 0; vertex < attributes.position.count; vertex++) {
      positions.push(...place([mesh, vertex]).toArray());
    }
    const count = index?.count ?? attributes.position.count;
    for (let corner = 0; corner < count; corner++) {
      triangles.push(first + (index ? index.getX(corner) : corner));
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(positions), 3));
  geometry.setIndex(triangles);
  return geometry;
}

/** Vertices of triangles, drawn at random. */
function sample({ meshes }, seed) {
  const corners = meshes.flatMap((mesh) => {
    const { index, attributes } = mesh.geometry;
    const used = index ? new Set(index.array) : new Set(Array(attributes.position.count).keys());
    return [...used].map((vertex) => [mesh, vertex]);
  });
  const next = random(seed);
  return corners.length <= VERTICES
    ? corners
    : Array.from({ length: VERTICES }, () => corners[Math.floor(next() * corners.length)]);
}

/** The greatest distance of points from the surface of a posed geometry. */
function farthest(points, surface) {
  const hit = {};
  return points.reduce((far, point) => Math.max(far, surface.closestPointToPoint(point, hit).distance), 0);
}

/** Sampled points and surface of the source in each pose. */
function reference(scene, shown) {
  const vertices = sample(scene, SEED + 1);
  return shown.map((show) => {
    show(scene);
    return { points: vertices.map((vertex) => place(vertex, new Vector3())), surface: new MeshBVH(posed(scene)) };
  });
}

function greatestError(scene, shown, wanted) {
  const vertices = sample(scene, SEED + 2);
  return shown.reduce((worst, show, pose) => {
    show(scene);
    const { points, surface } = wanted[pose];
    const own = vertices.map((vertex) => place(vertex, new Vector3()));
    return Math.max(worst, farthest(points, new MeshBVH(posed(scene))), farthest(own, surface));
  }, 0);
}

const before = await load(source);
atRest(before);
const heights = everyVertex(before).map((vertex) => place(vertex).y);
const height = heights.reduce((a, b) => Math.max(a, b)) - heights.reduce((a, b) => Math.min(a, b));
const shown = [atRest, ...poses(before, { count: POSES, fewest: 1, seed: SEED })];
const wanted = reference(before, shown);
console.log(JSON.stringify(await rows(files, height, null, (scene) => greatestError(scene, shown, wanted))));
