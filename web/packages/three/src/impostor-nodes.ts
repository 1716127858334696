import { DoubleSide, type Material } from 'three';
import {
  attribute,
  cameraProjectionMatrix,
  cameraWorldMatrix,
  Fn,
  If,
  length,
  Loop,
  materialColor,
  modelWorldMatrixInverse,
  normalLocal,
  positionGeometry,
  texture,
  uint,
  varying,
  vec2,
  vec3,
  vec4,
} from 'three/tsl';
import type { Node, NodeMaterial } from 'three/webgpu';

import { type CrowdMaterials, type CrowdPlaces, DRAW } from './crowd-shading.js';
import type { ImpostorShape } from './impostors.js';
import { held, matrix, moved, nodeMaterial, texelOf, turned } from './node-rows.js';

/** Materials whose squares show impostors, for `WebGPURenderer`. */
export function nodeImpostors(source: Material, shape: ImpostorShape, places: CrowdPlaces): CrowdMaterials {
  const material: NodeMaterial & { map?: unknown } = nodeMaterial(source);
  const { map } = source as { map?: Parameters<typeof texture>[0] };
  const corner = cornerOf(shape, places);
  material.positionNode = Fn(() => {
    const { place, normal } = corner();
    normalLocal.assign(normal);
    return place;
  })() as Node<'vec3'>;
  const at = varying(Fn(() => corner().uv)() as Node<'vec2'>);
  // They face the light, and shadows are usually those of back sides.
  material.shadowSide ??= DoubleSide;
  // Shadows are cut by the alpha of the node alone.
  material.map = null;
  const pictured = materialColor.mul(texture(map, at));
  const draw = attribute(DRAW, 'uvec2');
  const { colors } = places;
  material.colorNode = colors === undefined ? pictured : pictured.mul(vec4(varying(held(colors)(draw.x).xyz), 1));
  return { material };
}

interface Corner {
  readonly place: Node<'vec3'>;
  readonly normal: Node<'vec3'>;
  readonly uv: Node<'vec2'>;
}

/** Where a corner of a square is, in the space of the crowd and in the atlas. Called where nodes are built. */
function cornerOf({ places, rows, directions, cell, atlasPx }: ImpostorShape, { transforms }: CrowdPlaces): () => Corner {
  const image = texture(places);
  const table = (index: Node<'uint'>): Node<'vec4'> => texelOf(image, index);
  const worlds = held(transforms);
  const [width, height] = cell.size_px;
  return () => {
    const draw = attribute(DRAW, 'uvec2');
    const world = matrix(worlds, draw.x);
    const centre = table(draw.y.add(uint(rows))).xyz.toVar();
    // The eye in the space of the crowd, at infinity where rays are parallel.
    const parallel = cameraProjectionMatrix.mul(vec4(0, 0, 0, 1)).w;
    const eye = modelWorldMatrixInverse.mul(cameraWorldMatrix).mul(vec4(0, 0, parallel, parallel.oneMinus())).toVar();
    const away = eye.xyz.sub(moved(world, centre).mul(eye.w)).toVar();
    // Towards it in the space of the character, of any length: a rotation and one scale for all axes.
    const [x, y, z] = world;
    const toward = x.xyz.mul(away.x).add(y.xyz.mul(away.y)).add(z.xyz.mul(away.z)).toVar();
    const pitch = toward.y.atan(length(toward.xz));
    const row = table(uint(0)).toVar();
    const before = row.x.mul(0).toVar();
    Loop({ start: uint(1), end: uint(rows), type: 'uint', condition: '<' }, ({ i }) => {
      const next = table(i as Node<'uint'>).toVar();
      // Pitches ascend, so the last that is not above counts.
      If(next.x.lessThanEqual(pitch), () => {
        before.addAssign(row.w);
        row.assign(next);
      });
    });
    const turns = toward.x.atan(toward.z).div(2 * Math.PI);
    const yaw = turns.fract().mul(row.w).add(0.5).floor().mod(row.w).toVar();
    const angle = yaw.mul(2 * Math.PI).div(row.w).toVar();
    const [sin, cos] = [angle.sin().toVar(), angle.cos().toVar()];
    const [rise, level] = [row.y.sin().toVar(), row.y.cos().toVar()];
    const right = vec3(cos, 0, sin.negate()).toVar();
    const up = vec3(sin.mul(rise).negate(), level, cos.mul(rise).negate());
    const toEye = vec3(sin.mul(level), rise, cos.mul(level)).toVar();
    const side = positionGeometry.xy;
    const sizeM = vec2(width * cell.metres_per_px, height * cell.metres_per_px);
    const at = side.mul(sizeM).add(vec2(...cell.corner_m)).toVar();
    const place = centre.add(right.mul(at.x)).add(up.add(toEye.mul(row.z)).mul(at.y));
    const picture = draw.y.mul(uint(directions)).add(uint(before.add(yaw))).toVar();
    const columns = uint(cell.columns);
    const first = vec2(picture.mod(columns), picture.div(columns));
    const uv = first.add(vec2(side.x, side.y.oneMinus())).mul(vec2(width / atlasPx[0], height / atlasPx[1]));
    // Round from side to side.
    const normal = turned(world, toEye.add(right.mul(side.x.mul(2).sub(1))));
    return { place: moved(world, place), normal, uv };
  };
}
