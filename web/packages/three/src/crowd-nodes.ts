import type { Material } from 'three';
import {
  attribute,
  cross,
  dot,
  Fn,
  If,
  int,
  ivec2,
  Loop,
  materialColor,
  normalLocal,
  positionLocal,
  select,
  texture,
  textureLoad,
  uint,
  uintBitsToFloat,
  varying,
  vec3,
  vec4,
  vertexIndex,
} from 'three/tsl';
import {
  MeshBasicNodeMaterial,
  MeshLambertNodeMaterial,
  MeshPhongNodeMaterial,
  MeshPhysicalNodeMaterial,
  MeshStandardNodeMaterial,
  MeshToonNodeMaterial,
  type Node,
  type NodeMaterial,
  type TextureNode,
} from 'three/webgpu';

import {
  type CrowdMaterials,
  type CrowdShading,
  type CrowdShape,
  DRAW,
  entriesOf,
  MORPH_SET,
  weightsOf,
} from './crowd-shading.js';
import { DataRows } from './data-rows.js';

/** Three rows of a matrix. */
type Rows = readonly [Node<'vec4'>, Node<'vec4'>, Node<'vec4'>];

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

/** Poses crowds by nodes, for `WebGPURenderer` with WebGPU and with WebGL 2. */
export class NodeShading implements CrowdShading {
  materials(source: Material, shape: CrowdShape): CrowdMaterials {
    const Kind = KINDS[source.type] ?? MeshStandardNodeMaterial;
    const material = new Kind();
    const copied = Object.entries(source).filter(([key]) => !OWN.has(key));
    Object.assign(material, Object.fromEntries(copied));
    material.positionNode = poseNode(shape);
    if (shape.colors !== undefined) {
      const color = texel(held(shape.colors), character(shape)).xyz;
      material.colorNode = materialColor.mul(vec4(varying(color), 1));
    }
    return { material };
  }
}

function held(rows: DataRows): TextureNode {
  return rows.hold(texture(rows.texture));
}

function texel(from: TextureNode, index: Node<'uint'>): Node<'vec4'> {
  const width = uint(DataRows.WIDTH);
  return textureLoad(from, ivec2(int(index.mod(width)), int(index.div(width))));
}

function matrix(from: TextureNode, index: Node<'uint'>): Rows {
  const at = index.mul(uint(3)).toVar();
  return [texel(from, at), texel(from, at.add(uint(1))), texel(from, at.add(uint(2)))];
}

/** Which character an instance is. */
function character({ blended }: CrowdShape): Node<'uint'> {
  return blended ? attribute(DRAW, 'uvec4').w : attribute(DRAW, 'uvec2').x;
}

/** The position of a vertex in the space of the crowd; turns its normal on the way. */
function poseNode(shape: CrowdShape): Node<'vec3'> {
  const palettes = held(shape.palettes);
  const transforms = held(shape.transforms);
  const entry = entryOf(shape, palettes);
  const moveByMorphs = morphing(shape);
  const place = Fn(() => {
    const position = positionLocal.toVar();
    const normal = normalLocal.toVar();
    moveByMorphs(position, normal);
    const pose: Rows = [vec4(0).toVar(), vec4(0).toVar(), vec4(0).toVar()];
    for (let four = 0; four < shape.fours; four += 1) {
      const entries = attribute(entriesOf(four), 'uvec4');
      const weights = attribute(weightsOf(four), 'vec4');
      for (const component of ['x', 'y', 'z', 'w'] as const) {
        const added = entry(entries[component]);
        pose.forEach((row, i) => row.addAssign((added[i] as Node<'vec4'>).mul(weights[component])));
      }
    }
    const world = matrix(transforms, character(shape));
    normalLocal.assign(turned(world, turned(pose, normal)));
    return moved(world, moved(pose, position));
  });
  return place() as Node<'vec3'>;
}

/** How an entry of the palette of an instance is read. */
function entryOf(shape: CrowdShape, palettes: TextureNode): (entry: Node<'uint'>) => Rows {
  if (!shape.blended) {
    const first = attribute(DRAW, 'uvec2').y;
    return (entry) => matrix(palettes, first.add(entry));
  }
  const record = attribute(DRAW, 'uvec4');
  return (entry) => {
    const before = matrix(palettes, record.x.add(entry));
    const after = matrix(palettes, record.y.add(entry));
    const share = uintBitsToFloat(record.z) as Node as Node<'float'>;
    const [x, y, z] = before.map((row, i) => row.add((after[i] as Node<'vec4'>).sub(row).mul(share)));
    return [x, y, z] as Rows;
  };
}

type Changed = Node<'vec3'> & { addAssign(node: Node<'vec3'>): unknown };

/** Adds morph targets to a vertex. */
function morphing({ morphs, weights, morphTargets }: CrowdShape): (position: Changed, normal: Changed) => void {
  if (morphs === undefined) {
    return () => undefined;
  }
  const deltas = held(morphs.deltas);
  const sets = held(weights);
  return (position, normal) => {
    const first = attribute(MORPH_SET, 'uint').mul(uint(morphTargets)).toVar();
    const count = uint(morphs.targets);
    Loop({ start: uint(0), end: count, type: 'uint', condition: '<' }, ({ i }) => {
      const index = i as Node<'uint'>;
      const target = uint(texel(deltas, index).x);
      const weight = texel(sets, first.add(target)).x.toVar();
      If(weight.notEqual(0), () => {
        const at = index.mul(uint(morphs.vertices)).add(vertexIndex).mul(uint(2)).add(count).toVar();
        position.addAssign(texel(deltas, at).xyz.mul(weight));
        normal.addAssign(texel(deltas, at.add(uint(1))).xyz.mul(weight));
      });
    });
  };
}

function moved([x, y, z]: Rows, point: Node<'vec3'>): Node<'vec3'> {
  const p = vec4(point, 1).toVar();
  return vec3(dot(x, p), dot(y, p), dot(z, p));
}

/** By the cofactor matrix: normals point outwards of a matrix that mirrors too. */
function turned([x, y, z]: Rows, normal: Node<'vec3'>): Node<'vec3'> {
  const first = cross(y.xyz, z.xyz).toVar();
  const to = vec3(dot(first, normal), dot(cross(z.xyz, x.xyz), normal), dot(cross(x.xyz, y.xyz), normal));
  const side = select(dot(x.xyz, first).lessThan(0), -1, 1);
  return to.mul(side).normalize();
}
