import { type Material, MeshDepthMaterial, MeshDistanceMaterial, RGBADepthPacking } from 'three';

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
import type { DataRows, Holder } from './data-rows.js';
import { ROWS_GLSL, tinted } from './glsl-rows.js';
import { glslImpostors } from './impostor-glsl.js';
import type { ImpostorShape } from './impostors.js';

/** Poses crowds in the shaders of `WebGLRenderer`. */
export class GlslShading implements CrowdShading {
  materials(source: Material, shape: CrowdShape): CrowdMaterials {
    const material = source.clone();
    if (shape.coloredByVertices) {
      colorByVertices(material);
    }
    return {
      material: posed(material, shape, source),
      depth: posed(new MeshDepthMaterial({ depthPacking: RGBADepthPacking }), shape),
      distance: posed(new MeshDistanceMaterial(), shape),
    };
  }

  impostors(source: Material, shape: ImpostorShape, places: CrowdPlaces): CrowdMaterials {
    return glslImpostors(source, shape, places);
  }
}

/** Adds the posing to the shader of a material. */
function posed<M extends Material>(material: M, shape: CrowdShape, source?: Material): M {
  const holder = (rows: DataRows): Holder => rows.hold({ value: null });
  const uniforms: Record<string, Holder> = {
    articulaPalettes: holder(shape.palettes),
    articulaTransforms: holder(shape.transforms),
  };
  if (shape.colors !== undefined) {
    uniforms.articulaColors = holder(shape.colors);
  }
  if (shape.morphs !== undefined) {
    uniforms.articulaDeltas = holder(shape.morphs.deltas);
    uniforms.articulaMorphWeights = holder(shape.weights);
  }
  const variant = `articula ${JSON.stringify([
    shape.blended,
    shape.fours,
    shape.colors !== undefined,
    shape.morphs?.targets,
    shape.morphs?.vertices,
  ])}`;
  const sourceKey = source?.customProgramCacheKey() ?? '';
  material.customProgramCacheKey = () => variant + sourceKey;
  material.onBeforeCompile = (shader, renderer) => {
    source?.onBeforeCompile(shader, renderer);
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('void main() {', `${declarations(shape)}\nvoid main() {\n${body(shape)}`)
      .replace('#include <beginnormal_vertex>', '#include <beginnormal_vertex>\nobjectNormal = articulaNormal;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\ntransformed = articulaPosition;');
    if (shape.colors !== undefined) {
      shader.fragmentShader = tinted(shader.fragmentShader);
    }
  };
  return material;
}

const MORPH_DECLARATIONS = /* glsl */ `
attribute uint ${MORPH_SET};
uniform highp sampler2D articulaDeltas;
uniform highp sampler2D articulaMorphWeights;
`;

function declarations({ blended, fours, colors, morphs }: CrowdShape): string {
  const influences = Array.from(
    { length: fours },
    (_, i) => `attribute uvec4 ${entriesOf(i)};\nattribute vec4 ${weightsOf(i)};`,
  );
  return /* glsl */ `
${influences.join('\n')}
attribute ${blended ? 'uvec4' : 'uvec2'} ${DRAW};
uniform highp sampler2D articulaPalettes;
uniform highp sampler2D articulaTransforms;
${colors === undefined ? '' : 'uniform highp sampler2D articulaColors;\nvarying vec3 articulaColor;'}
${morphs === undefined ? '' : MORPH_DECLARATIONS}

${ROWS_GLSL}
void articulaAdd(inout ArticulaRows sum, uint entry, float weight) {
  if (weight == 0.0) return;
  ${
    blended
      ? `ArticulaRows a = articulaMatrix(articulaPalettes, ${DRAW}.x + entry);
  ArticulaRows b = articulaMatrix(articulaPalettes, ${DRAW}.y + entry);
  float share = uintBitsToFloat(${DRAW}.z);
  ArticulaRows m = ArticulaRows(a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share, a.z + (b.z - a.z) * share);`
      : `ArticulaRows m = articulaMatrix(articulaPalettes, ${DRAW}.y + entry);`
  }
  sum = ArticulaRows(sum.x + m.x * weight, sum.y + m.y * weight, sum.z + m.z * weight);
}
`;
}

function body({ blended, fours, colors, morphs, morphTargets }: CrowdShape): string {
  const character = blended ? `${DRAW}.w` : `${DRAW}.x`;
  const adds = Array.from({ length: fours * 4 }, (_, i) => {
    const component = 'xyzw'[i % 4];
    const four = Math.floor(i / 4);
    return `  articulaAdd(articulaPose, ${entriesOf(four)}.${component}, ${weightsOf(four)}.${component});`;
  });
  const moves = /* glsl */ `
  for (uint i = 0u; i < ${morphs?.targets}u; i++) {
    uint target = uint(articulaTexel(articulaDeltas, i).x);
    float weight = articulaTexel(articulaMorphWeights, ${MORPH_SET} * ${morphTargets}u + target).x;
    if (weight == 0.0) continue;
    uint at = ${morphs?.targets}u + (i * ${morphs?.vertices}u + uint(gl_VertexID)) * 2u;
    articulaPosition += articulaTexel(articulaDeltas, at).xyz * weight;
    articulaNormal += articulaTexel(articulaDeltas, at + 1u).xyz * weight;
  }`;
  return /* glsl */ `
  vec3 articulaPosition = position;
  vec3 articulaNormal = normal;
  ${morphs === undefined ? '' : moves}
  ArticulaRows articulaPose = ArticulaRows(vec4(0.0), vec4(0.0), vec4(0.0));
${adds.join('\n')}
  ArticulaRows articulaWorld = articulaMatrix(articulaTransforms, ${character});
  articulaPosition = articulaPoint(articulaWorld, articulaPoint(articulaPose, articulaPosition));
  articulaNormal = articulaTurn(articulaWorld, articulaTurn(articulaPose, articulaNormal));
  ${colors === undefined ? '' : `articulaColor = articulaTexel(articulaColors, ${character}).rgb;`}
`;
}
