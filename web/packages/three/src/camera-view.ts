import { packViews, type View } from '@articula/core';
import {
  type Camera,
  MathUtils,
  Matrix4,
  type Object3D,
  OrthographicCamera,
  PerspectiveCamera,
  Quaternion,
  Vector2,
  Vector3,
} from 'three';

/** The size of a picture in pixels, or a renderer that has one. */
export type DrawnSize =
  | { readonly width: number; readonly height: number }
  | { getDrawingBufferSize(target: Vector2): Vector2 };

const local = new Matrix4();
const position = new Vector3();
const rotation = new Quaternion();
const scale = new Vector3();
const drawn = new Vector2();

/** Field of view and distance that stand for an orthographic camera: nearly parallel rays. */
const FLAT_FOV_RAD = 0.02;

/** Returns cameras as the module takes them, in the space of `object`. */
export function packCameras(cameras: Camera | readonly Camera[], object: Object3D, size: DrawnSize): Float32Array {
  const seen = cameras instanceof Array ? (cameras as readonly Camera[]) : [cameras as Camera];
  return packViews(seen.map((camera) => cameraView(camera, object, size)));
}

/** Returns a camera as a view in the space of `object`; world matrices of both are brought up to date. */
function cameraView(camera: Camera, object: Object3D, size: DrawnSize): View {
  camera.updateWorldMatrix(true, false);
  object.updateWorldMatrix(true, false);
  local.copy(object.matrixWorld).invert().multiply(camera.matrixWorld);
  local.decompose(position, rotation, scale);
  let fov = MathUtils.degToRad(50);
  if (camera instanceof PerspectiveCamera) {
    fov = MathUtils.degToRad(camera.getEffectiveFOV());
  } else if (camera instanceof OrthographicCamera) {
    fov = FLAT_FOV_RAD;
    const height = ((camera.top - camera.bottom) / camera.zoom) * scale.y;
    const back = height / 2 / Math.tan(fov / 2);
    position.add(new Vector3(0, 0, back).applyQuaternion(rotation));
  }
  const { width, height } = 'getDrawingBufferSize' in size ? size.getDrawingBufferSize(drawn) : size;
  return {
    position: [position.x, position.y, position.z],
    rotation: [rotation.x, rotation.y, rotation.z, rotation.w],
    width,
    height,
    fov,
  };
}
