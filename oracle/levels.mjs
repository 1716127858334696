// Levels of ARTICULA_clustered_mesh as three.js draws them: `node levels.mjs FILE`.
// Prints [{node, groups, corners}], one entry for each primitive with levels that a node of the
// scene shows, in the order of the nodes: for each level, finest first, the number of groups
// that are drawn and the flat world positions of the triangles' corners, skinned at rest.
// `show` is the snippet of docs/formats/ARTICULA_clustered_mesh.md.

import { Vector3 } from "three";
import { openScene } from "./scene.mjs";

const [file] = process.argv.slice(2);
if (!file) {
  console.error("usage: node levels.mjs FILE");
  process.exit(2);
}

/** Meshes of one node: the node itself, or a group of one mesh for each primitive. */
function meshesOf(node) {
  return node.isMesh ? [node] : node.children.filter((child) => child.isMesh && !child.userData.isNode);
}

/** Gives a mesh `userData.show(level)`, if it has levels. */
async function addLevels(parser, mesh) {
  const { meshes: m, primitives: p } = parser.associations.get(mesh);
  const levels = parser.json.meshes[m].primitives[p].extensions?.ARTICULA_clustered_mesh;
  if (!levels) return null;
  mesh.geometry.setIndex(await parser.getDependency("accessor", levels.indices));
  mesh.material = [mesh.material];
  const count = levels.vertices.length;
  mesh.userData.show = (finer) => {
    const level = levels.version >= 2 ? finer : count - 1 - finer;
    mesh.geometry.clearGroups();
    let start = 0, from = -1;
    for (const c of [...levels.clusters, { first: 1, last: 0, triangles: 0 }]) {
      const shown = c.first <= level && level <= c.last;
      if (shown && from < 0) from = start;
      if (!shown && from >= 0) { mesh.geometry.addGroup(from, start - from, 0); from = -1; }
      start += 3 * c.triangles;
    }
  };
  return count;
}

/** Corners of what a mesh draws. */
function cornersOf({ geometry }, places) {
  const corners = [];
  for (const { start, count } of geometry.groups) {
    for (let i = start; i < start + count; i += 1) {
      corners.push(...places[geometry.index.getX(i)]);
    }
  }
  return corners;
}

const { gltf, nodes } = await openScene(file);
gltf.scene.updateMatrixWorld(true);
const shown = new Set();
gltf.scene.traverse((object) => shown.add(object));
nodes.forEach((node) => (node.userData.isNode = true));
const primitives = [];
for (const [index, node] of nodes.entries()) {
  for (const mesh of shown.has(node) ? meshesOf(node) : []) {
    const count = await addLevels(gltf.parser, mesh);
    if (count === null) continue;
    const vertices = mesh.geometry.attributes.position.count;
    const places = Array.from({ length: vertices }, (_, i) =>
      mesh.getVertexPosition(i, new Vector3()).applyMatrix4(mesh.matrixWorld).toArray(),
    );
    const corners = [];
    const groups = [];
    for (let level = 0; level < count; level += 1) {
      mesh.userData.show(level);
      groups.push(mesh.geometry.groups.length);
      corners.push(cornersOf(mesh, places));
    }
    primitives.push({ node: index, groups, corners });
  }
}
console.log(JSON.stringify(primitives));
