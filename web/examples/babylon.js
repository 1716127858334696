// A crowd in Babylon.js, by the arrays of @articula/core: one thin-instanced mesh a level, posed in its vertex shader.
import '@babylonjs/core/Meshes/thinInstanceMesh.js';

import { packViews } from '@articula/core';
import { Constants } from '@babylonjs/core/Engines/constants.js';
import { ShaderMaterial } from '@babylonjs/core/Materials/shaderMaterial.js';
import { RawTexture } from '@babylonjs/core/Materials/Textures/rawTexture.js';
import { Matrix, Quaternion, Vector3 } from '@babylonjs/core/Maths/math.vector.js';
import { Mesh } from '@babylonjs/core/Meshes/mesh.js';
import { VertexData } from '@babylonjs/core/Meshes/mesh.vertexData.js';

/** Texels of a row: 512 matrices of three rows. */
const WIDTH = 1536;

const VERTEX = `
precision highp float;
attribute vec3 position;
attribute vec3 normal;
attribute vec4 matricesIndices;
attribute vec4 matricesWeights;
attribute vec2 draw;
uniform mat4 viewProjection;
uniform highp sampler2D palettes;
uniform highp sampler2D transforms;
varying vec3 vNormal;

// The rows of a matrix are the columns of what is returned: multiply from the left.
mat3x4 matrixAt(highp sampler2D from, int index) {
  ivec2 at = ivec2(index * 3 % ${WIDTH}, index * 3 / ${WIDTH});
  return mat3x4(
    texelFetch(from, at, 0),
    texelFetch(from, at + ivec2(1, 0), 0),
    texelFetch(from, at + ivec2(2, 0), 0));
}

void main() {
  mat3x4 pose = mat3x4(0.0);
  for (int i = 0; i < 4; i++) {
    pose += matrixAt(palettes, int(draw.y + matricesIndices[i])) * matricesWeights[i];
  }
  mat3x4 world = matrixAt(transforms, int(draw.x));
  vNormal = vec4(vec4(normal, 0.0) * pose, 0.0) * world;
  vec3 placed = vec4(vec4(position, 1.0) * pose, 1.0) * world;
  gl_Position = viewProjection * vec4(placed, 1.0);
}`;

const FRAGMENT = `
precision highp float;
varying vec3 vNormal;

void main() {
  float light = 0.5 + 0.5 * dot(normalize(vNormal), normalize(vec3(1.0, 2.0, 1.5)));
  gl_FragColor = vec4(vec3(0.3 + 0.6 * light), 1.0);
}`;

/** Shows `count` instances of an asset. Its `crowd` is placed and played as that of the core package. */
export class BabylonCrowd {
  constructor(scene, articula, asset, count, options) {
    const { crowd, arrays } = articula.crowd(asset, count, { ...options, poseCache: false });
    this.crowd = crowd;
    this.arrays = arrays;
    this.scene = scene;
    this.material = new ShaderMaterial('crowd', scene, { vertexSource: VERTEX, fragmentSource: FRAGMENT }, {
      attributes: ['position', 'normal', 'matricesIndices', 'matricesWeights', 'draw'],
      uniforms: ['viewProjection'],
      samplers: ['palettes', 'transforms'],
    });
    this.levels = new Map();
    this.textures = {};
  }

  /** Advances, and shows what a camera of a right-handed scene sees. */
  update(dtSecs, camera, width, height) {
    const [scale, rotation, position] = [new Vector3(), new Quaternion(), new Vector3()];
    Matrix.Invert(camera.getViewMatrix(true)).decompose(scale, rotation, position);
    const view = { position: position.asArray(), rotation: rotation.asArray(), width, height, fov: camera.fov };
    this.crowd.frame(dtSecs, packViews([view]));
    const shown = this.arrays.groups().map((group) => ({ ...group, mesh: this.#mesh(group.level) }));
    this.#send('palettes', this.arrays.palettes);
    this.#send('transforms', this.arrays.transforms);
    for (const { mesh } of this.levels.values()) {
      mesh.thinInstanceCount = 0;
    }
    const { draws } = this.arrays;
    for (const { mesh, first, count } of shown) {
      mesh.draws.set(draws.subarray(first * 2, (first + count) * 2));
      mesh.mesh.thinInstanceCount = count;
      mesh.mesh.thinInstanceBufferUpdated('draw');
    }
  }

  /** The mesh of a level, made when it is first shown. */
  #mesh(level) {
    if (!this.levels.has(level)) {
      const geometry = this.crowd.mesh(level);
      const data = new VertexData();
      data.positions = geometry.positions();
      data.normals = geometry.normals();
      data.indices = geometry.triangles();
      data.matricesIndices = firstFour(Float32Array.from(geometry.entries()), geometry.influences);
      data.matricesWeights = firstFour(geometry.weights(), geometry.influences);
      geometry.free();
      const mesh = new Mesh(`level ${level}`, this.scene);
      data.applyToMesh(mesh);
      mesh.material = this.material;
      mesh.alwaysSelectAsActiveMesh = true;
      const draws = new Float32Array(this.crowd.count * 2);
      const places = new Float32Array(this.crowd.count * 16);
      mesh.thinInstanceSetBuffer('matrix', places, 16, true);
      mesh.thinInstanceSetBuffer('draw', draws, 2, false);
      this.levels.set(level, { mesh, draws });
    }
    return this.levels.get(level);
  }

  /** Sends matrices as a texture, which grows. */
  #send(name, matrices) {
    const rows = Math.ceil(matrices.length / (WIDTH * 4));
    let kept = this.textures[name];
    if (kept === undefined || kept.rows < rows) {
      kept?.texture.dispose();
      const data = new Float32Array(WIDTH * 4 * rows);
      const [format, type] = [Constants.TEXTUREFORMAT_RGBA, Constants.TEXTURETYPE_FLOAT];
      const sampling = Constants.TEXTURE_NEAREST_SAMPLINGMODE;
      const texture = new RawTexture(data, WIDTH, rows, format, this.scene, false, false, sampling, type);
      kept = { data, rows, texture };
      this.textures[name] = kept;
      this.material.setTexture(name, texture);
    }
    kept.data.set(matrices);
    kept.texture.update(kept.data);
  }

  dispose() {
    for (const { mesh } of this.levels.values()) {
      mesh.dispose();
    }
    for (const { texture } of Object.values(this.textures)) {
      texture.dispose();
    }
    this.material.dispose();
    this.crowd.free();
  }
}

/** The first four influences of each vertex. */
function firstFour(numbers, influences) {
  return influences === 4 ? numbers : numbers.filter((_, i) => i % influences < 4);
}
