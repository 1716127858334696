// What else shows many characters in three.js: a mixer for each, one mixer for an instanced mesh, and records that
// index a baked texture of poses.
import { InstancedMesh2 } from '@three.ez/instanced-mesh';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import * as SkeletonUtils from 'three/addons/utils/SkeletonUtils.js';

import { character } from './scene.js';

/** Poses a second of baked textures. */
export const BAKED_HZ = 30;

const FLOAT = 4;

export async function loadTheirs(url, clip) {
  const file = await new GLTFLoader().loadAsync(url);
  const animation = file.animations.find(({ name }) => name === clip);
  if (animation === undefined) {
    throw new Error(`no clip ${clip}`);
  }
  return { scene: file.scene, animation };
}

function skinned(root) {
  const found = [];
  root.traverse((object) => {
    if (object.isSkinnedMesh) {
      found.push(object);
    }
  });
  return found;
}

/** `SkinnedMesh` with a skeleton and an `AnimationMixer` for each character. */
export function mixers({ scene, animation }, count) {
  const root = new THREE.Group();
  const skeletons = new Set();
  const all = Array.from({ length: count }, (_, i) => {
    const { x, z, secs } = character(i, count);
    const figure = SkeletonUtils.clone(scene);
    figure.position.set(x, 0, z);
    root.add(figure);
    const mixer = new THREE.AnimationMixer(figure);
    mixer.clipAction(animation).play();
    mixer.setTime(secs);
    skinned(figure).forEach((mesh) => skeletons.add(mesh.skeleton));
    return mixer;
  });
  return {
    root,
    frame(dt) {
      for (const mixer of all) {
        mixer.update(dt);
      }
      root.updateMatrixWorld();
      for (const skeleton of skeletons) {
        skeleton.update();
      }
    },
    bytes: () => [...skeletons].reduce((sum, { boneMatrices }) => sum + FLOAT * boneMatrices.length, 0),
    dispose() {
      for (const skeleton of skeletons) {
        skeleton.dispose();
      }
    },
  };
}

/** One mixer that poses one skeleton for each instance in turn, as instanced-mesh is used. */
export function instancedMesh({ scene, animation }, count) {
  const figure = SkeletonUtils.clone(scene);
  const mixer = new THREE.AnimationMixer(figure);
  mixer.clipAction(animation).play();
  const meshes = skinned(figure).map((mesh) => {
    const instanced = new InstancedMesh2(mesh.geometry, mesh.material, { capacity: count });
    instanced.initSkeleton(mesh.skeleton);
    instanced.addInstances(count, (instance, i) => {
      const { x, z } = character(i, count);
      instance.position.set(x, 0, z);
    });
    return instanced;
  });
  figure.updateMatrixWorld(true);
  let now = 0;
  return {
    frame(dt) {
      now += dt;
      for (let i = 0; i < count; i += 1) {
        mixer.setTime(now + character(i, count).secs);
        for (const mesh of meshes) {
          mesh.setBonesAt(i);
        }
      }
    },
    bytes: () => meshes.reduce((sum, mesh) => sum + count * 16 * FLOAT * mesh.skeleton.bones.length, 0),
    dispose() {
      for (const mesh of meshes) {
        mesh.dispose();
      }
    },
  };
}

/** Eight bytes a character that say which pose of a texture it shows; nothing is culled, blended or left out. */
export function bakedRecords({ animation }, count) {
  const records = new Uint32Array(2 * count);
  const start = Float32Array.from({ length: count }, (_, i) => character(i, count).secs);
  const keys = Math.max(1, Math.round(animation.duration * BAKED_HZ));
  let now = 0;
  return {
    frame(dt) {
      now += dt;
      for (let i = 0; i < count; i += 1) {
        const key = ((now + start[i]) * BAKED_HZ) % keys;
        records[2 * i] = Math.floor(key);
        records[2 * i + 1] = i;
      }
    },
    bytes: () => records.byteLength,
    dispose() {},
  };
}

/** Figures of three.js itself at one moment; `hz` holds each pose as a texture without blending does. */
export function posedMixers(loaded, count, secs, hz) {
  const made = mixers(loaded, count);
  const held = (time) => (hz === undefined ? time : Math.floor(time * hz) / hz);
  made.root.children.forEach((figure, i) => {
    const mixer = new THREE.AnimationMixer(figure);
    mixer.clipAction(loaded.animation).play();
    mixer.setTime(held((secs + character(i, count).secs) % loaded.animation.duration));
  });
  return made.root;
}

/** The skinned meshes of a file, each with its matrices at some times of a clip: a row a time, a matrix a bone. */
export function posedSkeletons({ scene, animation }, times) {
  const figure = SkeletonUtils.clone(scene);
  const mixer = new THREE.AnimationMixer(figure);
  mixer.clipAction(animation).play();
  const matrix = new THREE.Matrix4();
  const poses = skinned(figure).map((mesh) => ({
    mesh,
    rows: new Float32Array(times.length * mesh.skeleton.bones.length * matrix.elements.length),
  }));
  times.forEach((time, row) => {
    mixer.setTime(time);
    figure.updateMatrixWorld(true);
    for (const { mesh, rows } of poses) {
      const { bones, boneInverses } = mesh.skeleton;
      bones.forEach((bone, i) => {
        matrix.multiplyMatrices(bone.matrixWorld, boneInverses[i]).multiply(mesh.bindMatrix);
        matrix.toArray(rows, (row * bones.length + i) * matrix.elements.length);
      });
    }
  });
  return poses;
}
