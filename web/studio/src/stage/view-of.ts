import { packViews } from '@articula/core';
import { MathUtils, Matrix4, type Object3D, Quaternion, Vector3 } from 'three';

import type { Viewport } from '../view/viewport.js';

const local = new Matrix4();
const position = new Vector3();
const rotation = new Quaternion();
const scale = new Vector3();

/** The camera of a column in the space of an object, as the module takes it. */
export function packCameras(viewport: Viewport, object: Object3D): Float32Array {
  const { camera, columnSize } = viewport;
  camera.updateWorldMatrix(true, false);
  object.updateWorldMatrix(true, false);
  local.copy(object.matrixWorld).invert().multiply(camera.matrixWorld);
  local.decompose(position, rotation, scale);
  return packViews([
    {
      position: [position.x, position.y, position.z],
      rotation: [rotation.x, rotation.y, rotation.z, rotation.w],
      width: columnSize.width,
      height: columnSize.height,
      fov: MathUtils.degToRad(camera.getEffectiveFOV()),
    },
  ]);
}
