import type { Geometry } from '@articula/core';
import { BufferAttribute, BufferGeometry, Float32BufferAttribute, Uint16BufferAttribute } from 'three';

/** Influences a vertex that three.js blends. */
const BLENDED = 4;

/** Triangles of one draw: those of a material, or of several that differ in colour alone. */
export interface MaterialRange {
  /** Index of the file's material, or -1; the first of several. */
  readonly material: number;
  /** Whether there are several, so that each part has its colour in those of its vertices. */
  readonly isJoined: boolean;
  /** First index and number of indices. */
  readonly start: number;
  readonly count: number;
}

/** Triangles of a mesh, those of a material together. */
export interface SortedTriangles {
  readonly index: BufferAttribute;
  readonly ranges: readonly MaterialRange[];
}

/** A part of a mesh. */
export interface MeshPart {
  readonly material: number;
  /** Vertex indices of its triangles. */
  readonly triangles: Uint32Array;
}

/** Returns the parts of a mesh by the material that draws them: their own, or as `Geometry.drawMaterials` joins them. */
export function partsByMaterial(mesh: Geometry, join: boolean): Map<number, MeshPart[]> {
  const triangles = mesh.triangles();
  const parts = mesh.parts();
  const drawn = join ? mesh.drawMaterials() : undefined;
  const byMaterial = new Map<number, MeshPart[]>();
  for (let i = 0; i + 2 < parts.length; i += 3) {
    const [material = -1, first = 0, count = 0] = parts.subarray(i, i + 3);
    if (count > 0) {
      const by = drawn?.[i / 3] ?? material;
      const found = byMaterial.get(by) ?? [];
      found.push({ material, triangles: triangles.subarray(first * 3, (first + count) * 3) });
      byMaterial.set(by, found);
    }
  }
  return byMaterial;
}

/** Returns the triangles of sorted parts with one range for each material. */
export function sortTriangles(vertices: number, byMaterial: ReadonlyMap<number, readonly MeshPart[]>): SortedTriangles {
  const all = [...byMaterial.values()].flat();
  const count = all.reduce((sum, part) => sum + part.triangles.length, 0);
  const sorted = vertices > 0xffff ? new Uint32Array(count) : new Uint16Array(count);
  const ranges: MaterialRange[] = [];
  let at = 0;
  for (const parts of byMaterial.values()) {
    const start = at;
    for (const { triangles } of parts) {
      sorted.set(triangles, at);
      at += triangles.length;
    }
    const [{ material } = { material: -1 }] = parts;
    const isJoined = parts.some((part) => part.material !== material);
    ranges.push({ material, isJoined, start, count: at - start });
  }
  return { index: new BufferAttribute(sorted, 1), ranges };
}

/** Adds the vertices of a mesh, but not what it is bound to. */
export function addVertices(geometry: BufferGeometry, mesh: Geometry): void {
  geometry.setAttribute('position', new Float32BufferAttribute(mesh.positions(), 3));
  geometry.setAttribute('normal', new Float32BufferAttribute(mesh.normals(), 3));
  geometry.setAttribute('uv', new Float32BufferAttribute(mesh.texcoords(), 2));
  const colors = mesh.colors();
  if (colors) {
    geometry.setAttribute('color', new Float32BufferAttribute(colors, 4));
  }
}

/** Returns the mesh as a geometry for `SkinnedMesh`, with the four greatest influences of each vertex. */
export function skinnedGeometry(mesh: Geometry): { geometry: BufferGeometry; ranges: readonly MaterialRange[] } {
  const geometry = new BufferGeometry();
  addVertices(geometry, mesh);
  const { entries, weights } = strongest(mesh);
  geometry.setAttribute('skinIndex', new Uint16BufferAttribute(entries, BLENDED));
  geometry.setAttribute('skinWeight', new Float32BufferAttribute(weights, BLENDED));
  const { index, ranges } = sortTriangles(mesh.vertices, partsByMaterial(mesh, false));
  geometry.setIndex(index);
  ranges.forEach(({ start, count }, i) => geometry.addGroup(start, count, i));
  return { geometry, ranges };
}

/** Adds the morph targets that move a vertex; returns their indices. */
export function addMorphs(geometry: BufferGeometry, mesh: Geometry, names: readonly string[]): number[] {
  const moving: number[] = [];
  const positions: BufferAttribute[] = [];
  const normals: BufferAttribute[] = [];
  for (let target = 0; target < mesh.morphs(); target += 1) {
    const moved = mesh.morphPositions(target);
    if (!moved) {
      continue;
    }
    const position = new Float32BufferAttribute(moved, 3);
    position.name = names[target] ?? String(target);
    positions.push(position);
    normals.push(new Float32BufferAttribute(mesh.morphNormals(target) ?? new Float32Array(moved.length), 3));
    moving.push(target);
  }
  if (moving.length > 0) {
    geometry.morphAttributes.position = positions;
    geometry.morphAttributes.normal = normals;
    geometry.morphTargetsRelative = true;
  }
  return moving;
}

/** The four greatest influences of each vertex, with the sum 1. */
function strongest(mesh: Geometry): { entries: Uint16Array; weights: Float32Array } {
  const entries = mesh.entries();
  const weights = mesh.weights();
  const { influences, vertices } = mesh;
  if (influences === BLENDED) {
    return { entries, weights };
  }
  const kept = { entries: new Uint16Array(vertices * BLENDED), weights: new Float32Array(vertices * BLENDED) };
  const order = Array.from({ length: influences }, (_, i) => i);
  for (let vertex = 0; vertex < vertices; vertex += 1) {
    const from = vertex * influences;
    const weight = (i: number): number => weights[from + i] ?? 0;
    const greatest = order.toSorted((a, b) => weight(b) - weight(a)).slice(0, BLENDED);
    const sum = greatest.reduce((total, i) => total + weight(i), 0) || 1;
    greatest.forEach((i, slot) => {
      kept.entries[vertex * BLENDED + slot] = entries[from + i] ?? 0;
      kept.weights[vertex * BLENDED + slot] = weight(i) / sum;
    });
  }
  return kept;
}
