import { DataRows } from './data-rows.js';

/** Matrices of three rows in textures, for shaders of `WebGLRenderer`. */
export const ROWS_GLSL = /* glsl */ `
struct ArticulaRows { vec4 x; vec4 y; vec4 z; };

vec4 articulaTexel(highp sampler2D from, uint index) {
  return texelFetch(from, ivec2(index % ${DataRows.WIDTH}u, index / ${DataRows.WIDTH}u), 0);
}

ArticulaRows articulaMatrix(highp sampler2D from, uint index) {
  uint at = index * 3u;
  return ArticulaRows(articulaTexel(from, at), articulaTexel(from, at + 1u), articulaTexel(from, at + 2u));
}

vec3 articulaPoint(ArticulaRows m, vec3 point) {
  vec4 p = vec4(point, 1.0);
  return vec3(dot(m.x, p), dot(m.y, p), dot(m.z, p));
}

// By the cofactor matrix: normals point outwards of a matrix that mirrors too.
vec3 articulaTurn(ArticulaRows m, vec3 n) {
  vec3 first = cross(m.y.xyz, m.z.xyz);
  vec3 moved = vec3(dot(first, n), dot(cross(m.z.xyz, m.x.xyz), n), dot(cross(m.x.xyz, m.y.xyz), n));
  return normalize(dot(m.x.xyz, first) < 0.0 ? -moved : moved);
}
`;

/** Multiplies the colour of a fragment shader by that of the character. */
export function tinted(fragmentShader: string): string {
  return fragmentShader
    .replace('void main() {', 'varying vec3 articulaColor;\nvoid main() {')
    .replace('#include <color_fragment>', '#include <color_fragment>\ndiffuseColor.rgb *= articulaColor;');
}
