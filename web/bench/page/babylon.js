// Babylon.js with baked vertex animation: its manager, its shaders and its thin instances. The poses are those of
// three.js, in the texture that `VertexAnimationBaker` would make of them, so that both show the same file.
import '@babylonjs/core/Meshes/thinInstanceMesh.js';

import { BakedVertexAnimationManager } from '@babylonjs/core/BakedVertexAnimation/bakedVertexAnimationManager.js';
import { Bone } from '@babylonjs/core/Bones/bone.js';
import { Skeleton } from '@babylonjs/core/Bones/skeleton.js';
import { FreeCamera } from '@babylonjs/core/Cameras/freeCamera.js';
import { Constants } from '@babylonjs/core/Engines/constants.js';
import { Engine } from '@babylonjs/core/Engines/engine.js';
import { HemisphericLight } from '@babylonjs/core/Lights/hemisphericLight.js';
import { StandardMaterial } from '@babylonjs/core/Materials/standardMaterial.js';
import { RawTexture } from '@babylonjs/core/Materials/Textures/rawTexture.js';
import { Color3 } from '@babylonjs/core/Maths/math.color.js';
import { Matrix, Vector3 } from '@babylonjs/core/Maths/math.vector.js';
import { Mesh } from '@babylonjs/core/Meshes/mesh.js';
import { VertexData } from '@babylonjs/core/Meshes/mesh.vertexData.js';
import { Scene } from '@babylonjs/core/scene.js';
import * as THREE from 'three';

import { character, makeCamera } from './scene.js';
import { BAKED_HZ, posedSkeletons } from './theirs.js';

/** Numbers of a matrix, and of the settings of an instance. */
const MATRIX = 16;
const SETTINGS = 4;

/** One time for all characters; each has the frame at which it began from the start. Nothing is culled or blended. */
export function bakedAnimation(loaded, count) {
  const stage = makeStage({ width: 1, height: 1 });
  const managers = bakedMeshes(stage.scene, loaded, count);
  return {
    frame(dt) {
      for (const manager of managers) {
        manager.time += dt;
      }
    },
    bytes: () => Float32Array.BYTES_PER_ELEMENT * managers.length,
    dispose: () => stage.engine.dispose(),
  };
}

/** Pictures at one time: as baked, of exact poses in the same shaders, and of nobody. */
export async function bakedPictures(loaded, count, secs, size) {
  const empty = await picture(size, () => {});
  const held = await picture(size, (scene) => {
    for (const manager of bakedMeshes(scene, loaded, count)) {
      manager.time = secs;
    }
  });
  const exact = await picture(size, (scene) => exactMeshes(scene, loaded, count, secs));
  return { empty, exact, held };
}

/** Meshes that play a clip baked at a rate; returns their managers. */
function bakedMeshes(scene, loaded, count) {
  const { duration } = loaded.animation;
  const frames = Math.max(1, Math.round(duration * BAKED_HZ));
  const times = Array.from({ length: frames }, (_, frame) => frame / BAKED_HZ);
  const settings = new Float32Array(SETTINGS * count);
  for (let i = 0; i < count; i += 1) {
    settings.set([0, frames - 1, (character(i, count).secs % duration) * BAKED_HZ, BAKED_HZ], SETTINGS * i);
  }
  return shown(scene, loaded, count, times, settings);
}

/** Meshes of which each character has a row of its own. */
function exactMeshes(scene, loaded, count, secs) {
  const times = Array.from({ length: count }, (_, i) => (secs + character(i, count).secs) % loaded.animation.duration);
  const settings = new Float32Array(SETTINGS * count);
  for (let i = 0; i < count; i += 1) {
    settings.set([i, i, 0, 0], SETTINGS * i);
  }
  return shown(scene, loaded, count, times, settings);
}

function shown(scene, loaded, count, times, settings) {
  const places = new Float32Array(MATRIX * count);
  for (let i = 0; i < count; i += 1) {
    const { x, z } = character(i, count);
    Matrix.Translation(x, 0, z).copyToArray(places, MATRIX * i);
  }
  const poses = posedSkeletons(loaded, times);
  return poses.map(({ mesh, rows }) => {
    const made = skinnedMesh(scene, mesh);
    const texels = (MATRIX / 4) * mesh.skeleton.bones.length;
    const [format, type] = [Constants.TEXTUREFORMAT_RGBA, Constants.TEXTURETYPE_FLOAT];
    const sampling = Constants.TEXTURE_NEAREST_SAMPLINGMODE;
    const manager = new BakedVertexAnimationManager(scene);
    manager.texture = new RawTexture(rows, texels, times.length, format, scene, false, false, sampling, type);
    made.bakedVertexAnimationManager = manager;
    made.thinInstanceSetBuffer('matrix', places, MATRIX, true);
    made.thinInstanceSetBuffer('bakedVertexAnimationSettingsInstanced', settings, SETTINGS, true);
    return manager;
  });
}

/** A mesh of three.js with a skeleton that only says how many influences a vertex has. */
function skinnedMesh(scene, { geometry, skeleton: { bones } }) {
  const { position, normal, skinIndex, skinWeight } = geometry.attributes;
  const data = new VertexData();
  data.positions = numbers(position);
  data.normals = numbers(normal);
  data.indices = Array.from(geometry.index.array);
  data.matricesIndices = numbers(skinIndex);
  data.matricesWeights = numbers(skinWeight);
  const mesh = new Mesh('character', scene);
  data.applyToMesh(mesh);
  mesh.skeleton = new Skeleton('skeleton', 'skeleton', scene);
  bones.forEach(({ name }) => new Bone(name, mesh.skeleton));
  mesh.alwaysSelectAsActiveMesh = true;
  mesh.material = new StandardMaterial('grey', scene);
  mesh.material.backFaceCulling = false;
  mesh.material.diffuseColor = new Color3(0.6, 0.6, 0.6);
  mesh.material.specularColor = Color3.Black();
  return mesh;
}

/** The numbers of an attribute, whatever its type. */
function numbers(attribute) {
  const { count, itemSize } = attribute;
  return Float32Array.from({ length: count * itemSize }, (_, i) => attribute.getComponent(Math.floor(i / itemSize), i % itemSize));
}

function makeStage({ width, height }) {
  const canvas = document.createElement('canvas');
  Object.assign(canvas, { width, height });
  const engine = new Engine(canvas, false, { preserveDrawingBuffer: true });
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  new HemisphericLight('sky', new Vector3(1, 2, 1.5), scene);
  const eye = makeCamera({ width, height });
  const camera = new FreeCamera('camera', new Vector3(...eye.position), scene);
  camera.fov = THREE.MathUtils.degToRad(eye.fov);
  camera.minZ = eye.near;
  camera.maxZ = eye.far;
  camera.setTarget(new Vector3(...eye.localToWorld(new THREE.Vector3(0, 0, -1))));
  return { canvas, engine, scene };
}

async function picture(size, fill) {
  const { canvas, engine, scene } = makeStage(size);
  fill(scene);
  await scene.whenReadyAsync();
  scene.render();
  const context = new OffscreenCanvas(size.width, size.height).getContext('2d');
  context.drawImage(canvas, 0, 0);
  engine.dispose();
  return context.getImageData(0, 0, size.width, size.height).data;
}
