// The skinned rest pose as three.js has it: `node skinned_positions.mjs FILE`.
// Prints [{node, positions, normals, indices}], one entry for each primitive that a node of the scene
// shows, in the order of the nodes: flat world positions and, unit and unskinned, the normals
// as they are stored (null without); corners of the triangles as indices of vertices.

import { Vector3 } from "three";
import { openScene } from "./scene.mjs";

const [file] = process.argv.slice(2);
if (!file) {
  console.error("usage: node skinned_positions.mjs FILE");
  process.exit(2);
}

/** Meshes of one node: the node itself, or a group of one mesh for each primitive. */
function meshesOf(node) {
  return node.isMesh ? [node] : node.children.filter((child) => child.isMesh && !child.userData.isNode);
}

function positionsOf(mesh) {
  const count = mesh.geometry.attributes.position.count;
  const at = new Vector3();
  return Array.from({ length: count }, (_, i) =>
    mesh.getVertexPosition(i, at).applyMatrix4(mesh.matrixWorld).toArray(),
  ).flat();
}

function normalsOf(mesh) {
  const normals = mesh.geometry.attributes.normal;
  const at = new Vector3();
  const all = (_, i) => at.fromBufferAttribute(normals, i).normalize().toArray();
  return normals ? Array.from({ length: normals.count }, all).flat() : null;
}

function indicesOf(mesh) {
  const { index, attributes } = mesh.geometry;
  return index ? Array.from(index.array) : Array.from({ length: attributes.position.count }, (_, i) => i);
}

const { gltf, nodes } = await openScene(file);
gltf.scene.updateMatrixWorld(true);
const shown = new Set();
gltf.scene.traverse((object) => shown.add(object));
nodes.forEach((node) => (node.userData.isNode = true));
const primitives = nodes.flatMap((node, index) =>
  shown.has(node)
    ? meshesOf(node).map((mesh) => ({
        node: index,
        positions: positionsOf(mesh),
        normals: normalsOf(mesh),
        indices: indicesOf(mesh),
      }))
    : [],
);
console.log(JSON.stringify(primitives));
