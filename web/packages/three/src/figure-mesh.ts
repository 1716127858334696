import {
  Bone,
  type BufferGeometry,
  DetachedBindMode,
  type Material,
  Matrix4,
  Skeleton,
  SkinnedMesh,
  Vector3,
  type Vector4,
} from 'three';

import { columnsOfRows } from './rows.js';

/** A skeleton with the matrices of a palette, in place of bones. */
export class PaletteSkeleton extends Skeleton {
  readonly #count: number;
  readonly #columns: Float32Array;

  constructor(count: number) {
    // Renderers read the number of bones, never the bones themselves.
    const bone = new Bone();
    const none = new Matrix4();
    super(new Array<Bone>(count).fill(bone), new Array<Matrix4>(count).fill(none));
    this.#count = count;
    this.#columns = new Float32Array(count * 16);
  }

  /** Takes over a palette: matrices of three rows. */
  setPalette(rows: Float32Array): void {
    columnsOfRows(this.#columns, rows, this.#count);
  }

  /** Returns a matrix of the palette, in `to`. */
  matrix(index: number, to: Matrix4): Matrix4 {
    return to.fromArray(this.#columns, index * 16);
  }

  /** Called by renderers before a frame. */
  override update(): void {
    (this.boneMatrices as Float32Array).set(this.#columns);
    if (this.boneTexture !== null) {
      this.boneTexture.needsUpdate = true;
    }
  }
}

const base = new Vector3();
const moved = new Vector3();
const entry = new Matrix4();
const point = new Vector3();

/** A skinned mesh whose matrices take rest positions to the space of the figure. */
export class FigureMesh extends SkinnedMesh<BufferGeometry, Material[]> {
  #palette: PaletteSkeleton;

  constructor(geometry: BufferGeometry, materials: Material[], skeleton: PaletteSkeleton) {
    super(geometry, materials);
    this.#palette = skeleton;
    this.bindMode = DetachedBindMode;
    this.bind(skeleton, new Matrix4());
  }

  /** Shows another mesh in its place. What it had is the caller's to dispose of. */
  show(geometry: BufferGeometry, materials: Material[], skeleton: PaletteSkeleton): void {
    this.geometry = geometry;
    this.material = materials;
    this.#palette = skeleton;
    this.bind(skeleton, this.bindMatrix);
    this.morphTargetDictionary = undefined;
    this.morphTargetInfluences = undefined;
    this.updateMorphTargets();
  }

  /** Moves a point as the vertex `index` is moved; ray casts and `computeBoundingBox` use it. */
  override applyBoneTransform(index: number, target: Vector3): Vector3;
  override applyBoneTransform(index: number, target: Vector4): Vector4;
  override applyBoneTransform(index: number, target: Vector3 | Vector4): Vector3 | Vector4 {
    const { skinIndex, skinWeight } = this.geometry.attributes;
    if (skinIndex === undefined || skinWeight === undefined) {
      return target;
    }
    base.set(target.x, target.y, target.z);
    moved.set(0, 0, 0);
    for (let slot = 0; slot < 4; slot += 1) {
      const weight = skinWeight.getComponent(index, slot);
      if (weight !== 0) {
        this.#palette.matrix(skinIndex.getComponent(index, slot), entry);
        moved.addScaledVector(point.copy(base).applyMatrix4(entry), weight);
      }
    }
    target.x = moved.x;
    target.y = moved.y;
    target.z = moved.z;
    return target;
  }
}
