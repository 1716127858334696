import type { Figure, FigureArrays, FigureOptions } from '@articula/core';
import { type Camera, Object3D, type Object3DEventMap, Sphere } from 'three';

import { type ArticulaAsset, indexIn } from './asset.js';
import { PoseBounds } from './bounds.js';
import { type DrawnSize, packCameras } from './camera-view.js';
import { FigureMesh, PaletteSkeleton } from './figure-mesh.js';
import { matrixOfRows } from './rows.js';

/** Bounds of the geometry of an asset, computed once for all of its figures. */
const bounds = new WeakMap<object, PoseBounds>();

/** No view: no error is seen. */
const NOWHERE = new Float32Array(0);

/** Events that a figure dispatches. */
export interface FigureEventMap extends Object3DEventMap {
  /** The figure passed an event of a clip. */
  clipevent: {
    readonly clip: string;
    readonly id: number;
    /** How much of the clip is played, 0 to 1. */
    readonly weight: number;
  };
}

const EVENT_NUMBERS = 3;

/** A clip that is played with the others of a figure. */
export interface LayerOptions {
  readonly weight?: number;
  /** Joints that it moves; all if left out. Children are not included by themselves. */
  readonly joints?: readonly string[];
  /** Whether it is added to the pose below it, in place of blended with it. */
  readonly additive?: boolean;
}

/**
 * One character that plays clips. Its mesh is a `SkinnedMesh` of three.js: all that works with one works with it.
 *
 * The figure holds memory of the module: {@link dispose} of it.
 */
export class ArticulaFigure extends Object3D<FigureEventMap> {
  readonly asset: ArticulaAsset;
  readonly mesh: FigureMesh;
  /** The figure of the core module, for what has no method here. */
  readonly core: Figure;
  readonly #arrays: FigureArrays;
  readonly #options: FigureOptions;
  readonly #skeleton: PaletteSkeleton;
  readonly #bounds: PoseBounds;
  readonly #sockets = new Map<number, Object3D>();

  constructor(asset: ArticulaAsset, options: FigureOptions = {}) {
    super();
    const { geometry, ranges, bindings, morphs } = asset.shape();
    const { figure, arrays } = asset.articula.figure(asset.core, options);
    this.asset = asset;
    this.name = asset.name;
    this.core = figure;
    this.#arrays = arrays;
    this.#options = options;
    this.#skeleton = new PaletteSkeleton(bindings);
    this.#bounds = bounds.get(geometry) ?? new PoseBounds(geometry, bindings);
    bounds.set(geometry, this.#bounds);
    const materials = ranges.map(({ material }) => asset.material(material));
    this.mesh = new FigureMesh(geometry, materials, this.#skeleton);
    this.mesh.name = asset.name;
    this.mesh.boundingSphere = new Sphere();
    if (morphs.length > 0) {
      this.mesh.updateMorphTargets();
    }
    this.add(this.mesh);
    this.core.setFullDetail();
    this.update(0);
  }

  /** Plays a clip from `secs` on, at once. */
  play(clip: string, secs = 0): this {
    this.core.play(this.asset.clip(clip), secs);
    return this;
  }

  /** Plays a clip, blending from what is played now. */
  fadeTo(clip: string, fadeSecs = 0.3): this {
    this.core.fadeTo(this.asset.clip(clip), fadeSecs);
    return this;
  }

  /** Adds a clip over the others; returns its index for {@link setLayerWeight}. */
  addLayer(clip: string, { weight = 1, joints, additive = false }: LayerOptions = {}): number {
    const chosen = joints?.map((name) => this.asset.joint(name)) ?? this.asset.joints.map((_, i) => i);
    return this.core.addLayer(this.asset.clip(clip), weight, Uint32Array.from(chosen), additive);
  }

  setLayerWeight(layer: number, weight: number): this {
    this.core.setLayerWeight(layer, weight);
    return this;
  }

  /** Shows a variant of the file's materials, one of `asset.variants`, or the usual ones. */
  setVariant(name: string | undefined): this {
    const variant = name === undefined ? -1 : indexIn(this.asset.variants, name, 'variant', this.asset.name);
    const { ranges } = this.asset.shape();
    this.mesh.material = ranges.map(({ material }) => this.asset.material(this.asset.materialOf(material, variant)));
    return this;
  }

  /** Moves all joints. */
  setFullDetail(): this {
    this.core.setFullDetail();
    return this;
  }

  /** Holds joints still whose motion is below so many pixels in the camera of {@link update}. */
  setTolerance(px: number): this {
    this.core.setTolerance(px);
    return this;
  }

  /** Moves the joints of a level of articulation. */
  setLoa(level: number): this {
    this.core.setLoa(level);
    return this;
  }

  /** Sets an expression: a name of {@link ArticulaAsset.expressions}. Returns false if the file has no such. */
  setExpression(name: string, weight: number): boolean {
    return this.core.setExpression(name, weight);
  }

  /** Sets a morph target in place of what clips do with it, until {@link clearMorphs}. */
  setMorph(name: string, weight: number): this {
    const target = this.asset.morphNames.indexOf(name);
    if (target < 0) {
      throw new RangeError(`${this.asset.name} has no morph target "${name}"`);
    }
    this.core.setMorph(target, weight);
    return this;
  }

  clearMorphs(): this {
    this.core.clearMorphs();
    return this;
  }

  /** Rotates a joint on top of its clip, until {@link clearPosed}: the hook of IK, look-at and the like. */
  poseJoint(name: string, rotation: { x: number; y: number; z: number; w: number }): this {
    this.core.poseJoint(this.asset.joint(name), rotation.x, rotation.y, rotation.z, rotation.w);
    return this;
  }

  clearPosed(): this {
    this.core.clearPosed();
    return this;
  }

  /** Returns an object that follows a joint: add to it what the character holds or wears. */
  socket(joint: string): Object3D {
    const index = this.asset.joint(joint);
    let socket = this.#sockets.get(index);
    if (socket === undefined) {
      socket = new Object3D();
      socket.name = joint;
      socket.matrixAutoUpdate = false;
      this.#sockets.set(index, socket);
      this.add(socket);
      this.#follow(socket, index, this.#arrays.joints);
    }
    return socket;
  }

  /**
   * Advances by `dtSecs` and takes over the pose. A tolerance needs the cameras and the size of the picture in pixels,
   * or the renderer.
   */
  update(dtSecs: number, cameras?: Camera | readonly Camera[], size?: DrawnSize): void {
    const seen = cameras !== undefined && size !== undefined;
    this.core.frame(dtSecs, seen ? packCameras(cameras, this, size) : NOWHERE);
    this.#take();
  }

  /**
   * Shows a time of a clock of the caller, in place of {@link update}: the clip that is played is at `clipSecs`, and
   * transitions go by `nowSecs`.
   */
  updateAt(nowSecs: number, clipSecs: number, cameras?: Camera | readonly Camera[], size?: DrawnSize): void {
    const seen = cameras !== undefined && size !== undefined;
    this.core.frameAt(nowSecs, clipSecs, seen ? packCameras(cameras, this, size) : NOWHERE);
    this.#take();
  }

  /** x, y, z in metres and yaw in radians by which the root moved in the last {@link update}. */
  get rootDelta(): readonly [number, number, number, number] {
    const [x = 0, y = 0, z = 0, yaw = 0] = this.core.rootDelta;
    return [x, y, z, yaw];
  }

  /** Returns another figure of the same asset, where this one is. */
  override clone(): this {
    return new ArticulaFigure(this.asset, this.#options).copy(this, false) as this;
  }

  /** Releases the figure. The asset stays. */
  override dispose(): void {
    super.dispose();
    this.removeFromParent();
    this.#skeleton.dispose();
    this.core.free();
  }

  #dispatch(): void {
    const { events } = this.core;
    for (let i = 0; i + EVENT_NUMBERS <= events.length; i += EVENT_NUMBERS) {
      const [clip = 0, id = 0, weight = 0] = events.subarray(i, i + EVENT_NUMBERS);
      this.dispatchEvent({ type: 'clipevent', clip: this.asset.clips[clip] ?? '', id, weight });
    }
  }

  /** Takes over the pose of the last frame. */
  #take(): void {
    this.#skeleton.setPalette(this.#arrays.palette);
    const influences = this.mesh.morphTargetInfluences;
    if (influences !== undefined) {
      const weights = this.#arrays.morphs;
      this.asset.shape().morphs.forEach((target, i) => {
        influences[i] = weights[target] ?? 0;
      });
    }
    const joints = this.#arrays.joints;
    for (const [index, socket] of this.#sockets) {
      this.#follow(socket, index, joints);
    }
    this.#bounds.enclose(this.mesh.boundingSphere as Sphere, (index, into) => this.#skeleton.matrix(index, into));
    if (this.#options.events !== undefined) {
      this.#dispatch();
    }
  }

  #follow(socket: Object3D, joint: number, joints: Float32Array): void {
    matrixOfRows(socket.matrix, joints, joint);
    socket.matrix.decompose(socket.position, socket.quaternion, socket.scale);
    socket.matrixWorldNeedsUpdate = true;
  }
}
