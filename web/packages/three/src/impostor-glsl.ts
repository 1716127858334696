import { DoubleSide, type Material, MeshDepthMaterial, MeshDistanceMaterial, RGBADepthPacking } from 'three';

import { type CrowdMaterials, type CrowdPlaces, DRAW } from './crowd-shading.js';
import type { DataRows, Holder } from './data-rows.js';
import { ROWS_GLSL, tinted } from './glsl-rows.js';
import type { ImpostorShape } from './impostors.js';

/** Materials whose squares show impostors, for `WebGLRenderer`. */
export function glslImpostors(source: Material, shape: ImpostorShape, places: CrowdPlaces): CrowdMaterials {
  const material = placed(source.clone(), shape, places, source);
  // They face the light, and shadows are usually those of back sides.
  material.shadowSide ??= DoubleSide;
  return {
    material,
    // `WebGLRenderer` hands them map and alpha test of the material.
    depth: placed(new MeshDepthMaterial({ depthPacking: RGBADepthPacking }), shape, places),
    distance: placed(new MeshDistanceMaterial(), shape, places),
  };
}

function placed<M extends Material>(material: M, shape: ImpostorShape, places: CrowdPlaces, source?: Material): M {
  const { colors, transforms } = places;
  const holder = (rows: DataRows): Holder => rows.hold({ value: null });
  const uniforms: Record<string, Holder> = {
    articulaPlaces: { value: shape.places },
    articulaTransforms: holder(transforms),
  };
  if (colors !== undefined) {
    uniforms.articulaColors = holder(colors);
  }
  const { rows, directions, cell, atlasPx } = shape;
  const variant = `articula impostors ${JSON.stringify([rows, directions, cell, atlasPx, colors !== undefined])}`;
  const sourceKey = source?.customProgramCacheKey() ?? '';
  material.customProgramCacheKey = () => variant + sourceKey;
  material.onBeforeCompile = (shader, renderer) => {
    source?.onBeforeCompile(shader, renderer);
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('void main() {', `${declarations(places)}\nvoid main() {\n${body(shape, places)}`)
      .replace('#include <uv_vertex>', '#include <uv_vertex>\n#ifdef USE_MAP\nvMapUv = articulaUv;\n#endif')
      .replace('#include <beginnormal_vertex>', '#include <beginnormal_vertex>\nobjectNormal = articulaNormal;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\ntransformed = articulaPosition;');
    if (colors !== undefined) {
      shader.fragmentShader = tinted(shader.fragmentShader);
    }
  };
  return material;
}

function declarations({ colors }: CrowdPlaces): string {
  return /* glsl */ `
attribute uvec2 ${DRAW};
uniform highp sampler2D articulaPlaces;
uniform highp sampler2D articulaTransforms;
${colors === undefined ? '' : 'uniform highp sampler2D articulaColors;\nvarying vec3 articulaColor;'}
${ROWS_GLSL}`;
}

function body({ rows, directions, cell, atlasPx }: ImpostorShape, { colors }: CrowdPlaces): string {
  const vec2 = ([x, y]: readonly [number, number]): string => `vec2(${float(x)}, ${float(y)})`;
  const [width, height] = cell.size_px;
  const size = vec2([width * cell.metres_per_px, height * cell.metres_per_px]);
  return /* glsl */ `
  ArticulaRows articulaWorld = articulaMatrix(articulaTransforms, ${DRAW}.x);
  vec3 articulaCentre = articulaTexel(articulaPlaces, ${rows}u + ${DRAW}.y).xyz;
  // The eye in the space of the crowd, at infinity where rays are parallel.
  float articulaIsParallel = projectionMatrix[3][3];
  vec4 articulaEye = inverse(modelViewMatrix) * vec4(0.0, 0.0, articulaIsParallel, 1.0 - articulaIsParallel);
  vec3 articulaAway = articulaEye.xyz - articulaEye.w * articulaPoint(articulaWorld, articulaCentre);
  // Towards it in the space of the character, of any length: a rotation and one scale for all axes.
  vec3 articulaToward = articulaAway.x * articulaWorld.x.xyz + articulaAway.y * articulaWorld.y.xyz + articulaAway.z * articulaWorld.z.xyz;
  float articulaPitch = atan(articulaToward.y, length(articulaToward.xz));
  vec4 articulaRow = articulaTexel(articulaPlaces, 0u);
  float articulaBefore = 0.0;
  for (uint i = 1u; i < ${rows}u; i++) {
    vec4 next = articulaTexel(articulaPlaces, i);
    if (next.x > articulaPitch) break;
    articulaBefore += articulaRow.w;
    articulaRow = next;
  }
  float articulaTurns = atan(articulaToward.x, articulaToward.z) / 6.2831853;
  float articulaYaw = mod(floor(fract(articulaTurns) * articulaRow.w + 0.5), articulaRow.w);
  float articulaAngle = 6.2831853 * articulaYaw / articulaRow.w;
  float articulaSin = sin(articulaAngle);
  float articulaCos = cos(articulaAngle);
  vec3 articulaRight = vec3(articulaCos, 0.0, -articulaSin);
  vec3 articulaUp = vec3(-articulaSin * sin(articulaRow.y), cos(articulaRow.y), -articulaCos * sin(articulaRow.y));
  vec3 articulaToEye = vec3(articulaSin * cos(articulaRow.y), sin(articulaRow.y), articulaCos * cos(articulaRow.y));
  vec2 articulaAt = ${vec2(cell.corner_m)} + position.xy * ${size};
  vec3 articulaPosition = articulaCentre + articulaRight * articulaAt.x + (articulaUp + articulaToEye * articulaRow.z) * articulaAt.y;
  articulaPosition = articulaPoint(articulaWorld, articulaPosition);
  // Round from side to side.
  vec3 articulaNormal = articulaTurn(articulaWorld, articulaToEye + articulaRight * (2.0 * position.x - 1.0));
  uint articulaPicture = ${DRAW}.y * ${directions}u + uint(articulaBefore + articulaYaw);
  vec2 articulaCell = vec2(articulaPicture % ${cell.columns}u, articulaPicture / ${cell.columns}u);
  vec2 articulaUv = (articulaCell + vec2(position.x, 1.0 - position.y)) * ${vec2([width / atlasPx[0], height / atlasPx[1]])};
  ${colors === undefined ? '' : `articulaColor = articulaTexel(articulaColors, ${DRAW}.x).rgb;`}
`;
}

/** A number as GLSL has floats. */
function float(number: number): string {
  return Number.isInteger(number) ? number.toFixed(1) : String(number);
}
