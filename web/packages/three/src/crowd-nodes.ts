import type { Material } from 'three';
import { attribute, Fn, If, Loop, materialColor, normalLocal, positionLocal, uint, uintBitsToFloat, varying, vec4, vertexIndex } from 'three/tsl';
import type { Node } from 'three/webgpu';

import {
  colorByVertices,
  type CrowdMaterials,
  type CrowdPlaces,
  type CrowdShading,
  type CrowdShape,
  DRAW,
  entriesOf,
  MORPH_SET,
  weightsOf,
} from './crowd-shading.js';
import { nodeImpostors } from './impostor-nodes.js';
import type { ImpostorShape } from './impostors.js';
import { held, matrix, moved, nodeMaterial, type Rows, type RowSource, turned } from './node-rows.js';

/** Poses crowds by nodes, for `WebGPURenderer` with WebGPU and with WebGL 2. */
export class NodeShading implements CrowdShading {
  materials(source: Material, shape: CrowdShape): CrowdMaterials {
    const material = nodeMaterial(source);
    if (shape.coloredByVertices) {
      colorByVertices(material);
    }
    material.positionNode = poseNode(shape);
    if (shape.colors !== undefined) {
      const color = held(shape.colors)(character(shape)).xyz;
      material.colorNode = materialColor.mul(vec4(varying(color), 1));
    }
    return { material };
  }

  impostors(source: Material, shape: ImpostorShape, places: CrowdPlaces): CrowdMaterials {
    return nodeImpostors(source, shape, places);
  }
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
function entryOf(shape: CrowdShape, palettes: RowSource): (entry: Node<'uint'>) => Rows {
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
      const target = uint(deltas(index).x);
      const weight = sets(first.add(target)).x.toVar();
      If(weight.notEqual(0), () => {
        const at = index.mul(uint(morphs.vertices)).add(vertexIndex).mul(uint(2)).add(count).toVar();
        position.addAssign(deltas(at).xyz.mul(weight));
        normal.addAssign(deltas(at.add(uint(1))).xyz.mul(weight));
      });
    });
  };
}
