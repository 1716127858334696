import type { Material } from 'three';
import { cross, dot, Fn, int, ivec2, select, storage, texture, textureLoad, uint, vec3, vec4 } from 'three/tsl';
import {
  MeshBasicNodeMaterial,
  MeshLambertNodeMaterial,
  MeshPhongNodeMaterial,
  MeshPhysicalNodeMaterial,
  MeshStandardNodeMaterial,
  MeshToonNodeMaterial,
  type Node,
  type NodeBuilder,
  type NodeMaterial,
  StorageBufferAttribute,
  type StorageBufferNode,
  type TextureNode,
} from 'three/webgpu';

import { DataRows, type Holder, type MakeBuffer } from './data-rows.js';

/** Three rows of a matrix. */
export type Rows = readonly [Node<'vec4'>, Node<'vec4'>, Node<'vec4'>];

/** Node materials by the type of the material that they stand for. */
const KINDS: Readonly<Record<string, new () => NodeMaterial>> = {
  MeshBasicMaterial: MeshBasicNodeMaterial,
  MeshLambertMaterial: MeshLambertNodeMaterial,
  MeshPhongMaterial: MeshPhongNodeMaterial,
  MeshPhysicalMaterial: MeshPhysicalNodeMaterial,
  MeshStandardMaterial: MeshStandardNodeMaterial,
  MeshToonMaterial: MeshToonNodeMaterial,
};

/** What every material has of its own. */
const OWN = new Set(['uuid', '_listeners', 'version']);

/** Returns a node material that looks as another one. */
export function nodeMaterial(source: Material): NodeMaterial {
  const Kind = KINDS[source.type] ?? MeshStandardNodeMaterial;
  const material = new Kind();
  const copied = Object.entries(source).filter(([key]) => !OWN.has(key));
  return Object.assign(material, Object.fromEntries(copied));
}

/** Reads four numbers of rows: with WebGPU from a buffer, of which parts can be sent, else from a texture. */
export type RowSource = (index: Node<'uint'>) => Node<'vec4'>;

export function held(rows: DataRows): RowSource {
  const image = rows.hold(texture(rows.texture));
  let buffer: StorageBufferNode<'vec4' | 'float'> | undefined;
  return (index) => {
    const read = Fn((_none: unknown, builder: NodeBuilder) => {
      if (!isWebGPU(builder.renderer)) {
        return texelOf(image, index);
      }
      buffer ??= storageOf(rows);
      return buffer.element(index);
    });
    return read() as unknown as Node<'vec4'>;
  };
}

function isWebGPU(renderer: NodeBuilder['renderer']): boolean {
  return (renderer as { backend?: { isWebGPUBackend?: boolean } }).backend?.isWebGPUBackend === true;
}

/** A node of the buffer of rows, which follows when it is made anew. */
function storageOf(rows: DataRows): StorageBufferNode<'vec4' | 'float'> {
  const make: MakeBuffer = (numbers, channels) => new StorageBufferAttribute(numbers, channels);
  const buffer = rows.buffer(make) as StorageBufferAttribute;
  // Without a number of elements, since it may grow.
  const made = storage(buffer, rows.channels === 4 ? 'vec4' : 'float', 0).toReadOnly();
  rows.holdBuffer(made as Holder);
  return made as StorageBufferNode<'vec4' | 'float'>;
}

export function texelOf(from: TextureNode, index: Node<'uint'>): Node<'vec4'> {
  const width = uint(DataRows.WIDTH);
  return textureLoad(from, ivec2(int(index.mod(width)), int(index.div(width))));
}

export function matrix(from: RowSource, index: Node<'uint'>): Rows {
  const at = index.mul(uint(3)).toVar();
  return [from(at), from(at.add(uint(1))), from(at.add(uint(2)))];
}

export function moved([x, y, z]: Rows, point: Node<'vec3'>): Node<'vec3'> {
  const p = vec4(point, 1).toVar();
  return vec3(dot(x, p), dot(y, p), dot(z, p));
}

/** By the cofactor matrix: normals point outwards of a matrix that mirrors too. */
export function turned([x, y, z]: Rows, normal: Node<'vec3'>): Node<'vec3'> {
  const first = cross(y.xyz, z.xyz).toVar();
  const to = vec3(dot(first, normal), dot(cross(z.xyz, x.xyz), normal), dot(cross(x.xyz, y.xyz), normal));
  const side = select(dot(x.xyz, first).lessThan(0), -1, 1);
  return to.mul(side).normalize();
}
