import type { DrawGroup, Geometry } from '@articula/core';
import {
  BufferAttribute,
  BufferGeometry,
  type Color,
  DynamicDrawUsage,
  Float32BufferAttribute,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  IntType,
  Mesh,
} from 'three';

import { addVertices, type MaterialRange, type MeshPart, partsByMaterial, sortTriangles } from './geometry.js';
import { type CrowdMaterials, type CrowdMorphs, DRAW, entriesOf, MORPH_SET, weightsOf } from './crowd-shading.js';
import { DataRows } from './data-rows.js';

/** Integers of an instance: those of a draw, a record, a stepped draw or an impostor; and which is the character. */
export const DRAW_WORDS = {
  palette: { count: 2, character: 0 },
  record: { count: 4, character: 3 },
  step: { count: 2, character: 0 },
  impostor: { count: 2, character: 0 },
} as const;

/** What the instances of a group draw. */
export interface GroupShape {
  readonly geometry: BufferGeometry;
  readonly ranges: readonly MaterialRange[];
  readonly morphs: CrowdMorphs | undefined;
}

/** The mesh of a level: what its draws of all kinds share. */
export class LevelMesh implements GroupShape {
  readonly geometry = new BufferGeometry();
  readonly ranges: readonly MaterialRange[];
  /** Runs of four influences. */
  readonly fours: number;
  readonly morphs: CrowdMorphs | undefined;

  /** `colorOf` returns the colour of a material. */
  constructor(mesh: Geometry, colorOf: (material: number) => Color) {
    addVertices(this.geometry, mesh);
    this.fours = mesh.influences / 4;
    const entries = mesh.entries();
    const weights = mesh.weights();
    for (let four = 0; four < this.fours; four += 1) {
      const attribute = new BufferAttribute(every(entries, mesh.influences, four), 4);
      attribute.gpuType = IntType;
      this.geometry.setAttribute(entriesOf(four), attribute);
      this.geometry.setAttribute(weightsOf(four), new BufferAttribute(every(weights, mesh.influences, four), 4));
    }
    const parts = partsByMaterial(mesh, true);
    const { index, ranges } = sortTriangles(mesh.vertices, parts);
    this.geometry.setIndex(index);
    this.ranges = ranges;
    const joined = [...parts.values()].filter((_, i) => ranges[i]?.isJoined).flat();
    if (joined.length > 0) {
      this.geometry.setAttribute('color', new Float32BufferAttribute(colorsOf(mesh, joined, colorOf), 4));
    }
    this.morphs = morphsOf(mesh);
  }

  dispose(): void {
    this.geometry.dispose();
    this.morphs?.deltas.dispose();
  }
}

/** Instances of one kind and level: a mesh for each draw. */
export class GroupMeshes {
  readonly meshes: readonly Mesh[];
  readonly #draws: InstancedBufferAttribute;
  readonly #sets: InstancedBufferAttribute | undefined;

  constructor(kind: DrawGroup['kind'], level: GroupShape, count: number, materials: readonly CrowdMaterials[]) {
    const numbers = DRAW_WORDS[kind].count;
    this.#draws = instanced(new Uint32Array(count * numbers), numbers);
    this.#sets = level.morphs === undefined ? undefined : instanced(new Uint32Array(count), 1);
    this.meshes = level.ranges.map((range, i) => {
      const geometry = new InstancedBufferGeometry();
      geometry.index = level.geometry.index;
      Object.assign(geometry.attributes, level.geometry.attributes);
      geometry.setAttribute(DRAW, this.#draws);
      if (this.#sets !== undefined) {
        geometry.setAttribute(MORPH_SET, this.#sets);
      }
      geometry.setDrawRange(range.start, range.count);
      return groupMesh(geometry, materials[i] as CrowdMaterials);
    });
  }

  /** Shows the instances of a group; `list` has those of its kind. `which` chooses some, by their places in the group. */
  show(group: DrawGroup, list: Uint32Array, which?: readonly number[]): void {
    const { array, itemSize } = this.#draws;
    const shown = list.subarray(group.first * itemSize, (group.first + group.count) * itemSize);
    const count = which?.length ?? group.count;
    if (which === undefined) {
      array.set(shown);
    } else {
      which.forEach((from, to) => array.set(shown.subarray(from * itemSize, (from + 1) * itemSize), to * itemSize));
    }
    send(this.#draws, count * itemSize);
    if (this.#sets !== undefined) {
      const sets = this.#sets.array;
      for (let i = 0; i < count; i += 1) {
        const place = which?.[i] ?? i;
        sets[i] = place < group.morphSets ? group.firstMorphSet + place + 1 : 0;
      }
      send(this.#sets, count);
    }
    for (const mesh of this.meshes) {
      (mesh.geometry as InstancedBufferGeometry).instanceCount = count;
      mesh.visible = true;
    }
  }

  hide(): void {
    for (const mesh of this.meshes) {
      mesh.visible = false;
    }
  }

  dispose(): void {
    for (const mesh of this.meshes) {
      mesh.removeFromParent();
      mesh.geometry.dispose();
    }
  }
}

function groupMesh(geometry: InstancedBufferGeometry, { material, depth, distance }: CrowdMaterials): Mesh {
  const mesh = new Mesh(geometry, material);
  // The crowd culls its characters itself, and answers ray casts.
  mesh.frustumCulled = false;
  mesh.raycast = () => undefined;
  mesh.matrixAutoUpdate = false;
  if (depth !== undefined) {
    mesh.customDepthMaterial = depth;
  }
  if (distance !== undefined) {
    mesh.customDistanceMaterial = distance;
  }
  return mesh;
}

function instanced(numbers: Uint32Array, itemSize: number): InstancedBufferAttribute {
  const attribute = new InstancedBufferAttribute(numbers, itemSize);
  attribute.gpuType = IntType;
  attribute.setUsage(DynamicDrawUsage);
  return attribute;
}

function send(attribute: InstancedBufferAttribute, numbers: number): void {
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, numbers);
  attribute.needsUpdate = true;
}

/** Colours of vertices, of some parts multiplied with that of their material. */
function colorsOf(mesh: Geometry, parts: readonly MeshPart[], colorOf: (material: number) => Color): Float32Array {
  const colors = mesh.colors() ?? new Float32Array(mesh.vertices * 4).fill(1);
  const own = colors.slice();
  for (const { material, triangles } of parts) {
    const { r, g, b } = colorOf(material);
    for (const vertex of triangles) {
      const at = vertex * 4;
      colors[at] = (own[at] ?? 1) * r;
      colors[at + 1] = (own[at + 1] ?? 1) * g;
      colors[at + 2] = (own[at + 2] ?? 1) * b;
    }
  }
  return colors;
}

/** Returns one run of four of the influences of each vertex. */
function every<T extends Uint16Array | Float32Array>(all: T, influences: number, four: number): T {
  if (influences === 4) {
    return all;
  }
  return all.filter((_, i) => Math.floor((i % influences) / 4) === four) as T;
}

/** Returns the targets that move a vertex. */
function morphsOf(mesh: Geometry): CrowdMorphs | undefined {
  const targets: number[] = [];
  const moves: Float32Array[] = [];
  for (let target = 0; target < mesh.morphs(); target += 1) {
    const positions = mesh.morphPositions(target);
    if (positions) {
      targets.push(target);
      moves.push(deltasOf(positions, mesh.morphNormals(target)));
    }
  }
  if (targets.length === 0) {
    return undefined;
  }
  const deltas = new DataRows(4);
  deltas.write(Float32Array.from(targets.flatMap((target) => [target, 0, 0, 0])));
  moves.forEach((move, i) => deltas.write(move, targets.length * 4 + i * move.length));
  return { deltas, targets: targets.length, vertices: mesh.vertices };
}

/** Two texels for each vertex: what its position and its normal are moved by. */
function deltasOf(positions: Float32Array, normals: Float32Array | undefined): Float32Array {
  const vertices = positions.length / 3;
  const texels = new Float32Array(vertices * 8);
  for (let vertex = 0; vertex < vertices; vertex += 1) {
    texels.set(positions.subarray(vertex * 3, vertex * 3 + 3), vertex * 8);
    texels.set(normals?.subarray(vertex * 3, vertex * 3 + 3) ?? [], vertex * 8 + 4);
  }
  return texels;
}
