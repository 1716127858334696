import type { Crowd, CrowdArrays, CrowdOptions, DrawGroup } from '@articula/core';
import {
  type Camera,
  Color,
  type ColorRepresentation,
  type EventListener,
  type Intersection,
  Matrix4,
  Object3D,
  type Object3DEventMap,
  type Quaternion,
  type Raycaster,
  Ray,
  Vector3,
} from 'three';

import { type ArticulaAsset, indexIn } from './asset.js';
import { type DrawnSize, packCameras } from './camera-view.js';
import { GroupMeshes, LevelMesh } from './crowd-mesh.js';
import type { CrowdMaterials, CrowdShading, CrowdShape } from './crowd-shading.js';
import { DataRows } from './data-rows.js';

/** Events that a crowd dispatches. */
export interface CrowdEventMap extends Object3DEventMap {
  /** A character passed an event of a clip, seen or not. */
  clipevent: {
    readonly character: number;
    readonly clip: string;
    readonly id: number;
    /** How much of the clip is played, 0 to 1. */
    readonly weight: number;
  };
}

const EVENT_NUMBERS = 4;
const toLocal = new Matrix4();
const localRay = new Ray();

/**
 * Many instances of one character. It plans what the cameras of {@link PosedCrowd.update} see: characters that none of
 * them sees are not drawn, in shadows neither.
 */
export class PosedCrowd extends Object3D<CrowdEventMap> {
  readonly asset: ArticulaAsset;
  override readonly count: number;
  readonly clips: readonly string[];
  readonly warnings: readonly string[];
  /** The crowd of the core module, for what has no method here. */
  readonly core: Crowd;
  /** Milliseconds that the last {@link update} took to plan and to evaluate. */
  lastFrameMs = 0;
  readonly #arrays: CrowdArrays;
  readonly #shading: CrowdShading;
  readonly #travels: boolean;
  readonly #morphTargets: number;
  readonly #levels = new Map<number, LevelMesh>();
  readonly #groups = new Map<string, GroupMeshes>();
  readonly #materials = new Map<string, CrowdMaterials>();
  readonly #palettes = new DataRows(4);
  readonly #cached = new DataRows(4);
  readonly #transforms = new DataRows(4);
  readonly #weights = new DataRows(1);
  #colors: DataRows | undefined;
  #cacheIsSent = false;
  #isMoved = true;
  #hears = false;

  constructor(asset: ArticulaAsset, count: number, shading: CrowdShading, options: CrowdOptions = {}) {
    super();
    const { crowd, arrays } = asset.articula.crowd(asset.core, count, options);
    this.asset = asset;
    this.name = asset.name;
    this.count = count;
    this.core = crowd;
    this.clips = crowd.clips;
    this.warnings = crowd.warnings;
    this.#arrays = arrays;
    this.#shading = shading;
    this.#travels = options.rootMotion === 'extracted';
    const defaults = asset.core.morphDefaults;
    this.#morphTargets = defaults.length;
    this.#weights.write(defaults);
  }

  /** Places a character: x, y, z in metres and the turn about +Y in radians, in the space of the crowd. */
  place(character: number, x: number, y: number, z: number, yaw = 0): this {
    this.core.place(character, x, y, z, yaw);
    this.#isMoved = true;
    return this;
  }

  /** Places a character with any rotation, and scale if given. */
  setTransform(character: number, position: Vector3, rotation: Quaternion, scale?: number): this {
    const { x, y, z } = position;
    this.core.setTransform(character, x, y, z, rotation.x, rotation.y, rotation.z, rotation.w);
    if (scale !== undefined) {
      this.core.setScale(character, scale);
    }
    this.#isMoved = true;
    return this;
  }

  /** Plays a clip from `secs` on, at once. */
  play(character: number, clip: string, secs = 0): this {
    this.core.play(character, indexIn(this.clips, clip, 'clip', this.name), secs);
    return this;
  }

  /** Plays a clip, blending from what is played now. */
  fadeTo(character: number, clip: string, fadeSecs = 0.3): this {
    this.core.fadeTo(character, indexIn(this.clips, clip, 'clip', this.name), fadeSecs);
    return this;
  }

  /** Shows all joints of all characters. */
  setFullDetail(): this {
    this.core.setFull();
    return this;
  }

  /** Leaves out what is off by less than so many pixels; one pixel at first. */
  setTolerance(px: number): this {
    this.core.setTolerance(px);
    return this;
  }

  /** Finds the tolerance at which planning and evaluating a frame take so many milliseconds. */
  setBudget(ms: number): this {
    this.core.setBudget(ms);
    return this;
  }

  /** 1 is usual, 2 halves the error that a character may have. */
  setImportance(character: number, importance: number): this {
    this.core.setImportance(character, importance);
    return this;
  }

  /** Who blends poses of the cache: the processor, or shaders, which then get 16 bytes a character. */
  setPoseCache(use: 'none' | 'cpu' | 'gpu'): this {
    this.core.usePoseCache(use);
    return this;
  }

  /** Multiplies the colour of the materials for one character. */
  setColorAt(character: number, color: ColorRepresentation): this {
    if (this.#colors === undefined) {
      this.#colors = new DataRows(4);
      this.#colors.write(new Float32Array(this.count * 4).fill(1));
      this.#rebuild();
    }
    const { r, g, b } = new Color(color);
    this.#colors.write(Float32Array.of(r, g, b, 1), character * 4);
    return this;
  }

  /** Adds a listener; events of clips are collected once one listens to them. */
  override addEventListener<T extends Extract<keyof CrowdEventMap, string>>(
    type: T,
    listener: EventListener<CrowdEventMap[T], T, this>,
  ): void {
    if (type === 'clipevent' && !this.#hears) {
      this.#hears = true;
      this.core.setEvents(true);
    }
    super.addEventListener(type, listener);
  }

  /** Level at which the last frame shows a character, 0 the finest; -1 if it is not shown. */
  levelOf(character: number): number {
    return this.core.level(character);
  }

  /**
   * Advances by `dtSecs`, for one camera or several: what any of them sees is drawn at the detail that it needs.
   * `size` is the size of the picture in pixels, or the renderer.
   */
  update(dtSecs: number, cameras: Camera | readonly Camera[], size: DrawnSize): void {
    const views = packCameras(cameras, this, size);
    const start = performance.now();
    this.core.frame(dtSecs, views);
    this.lastFrameMs = performance.now() - start;
    this.core.observe(this.lastFrameMs);
    if (this.#travels) {
      this.core.travel();
      this.#isMoved = true;
    }
    this.#send();
    this.#show();
    if (this.#hears) {
      this.#dispatch();
    }
  }

  /** Finds the first character that the ray meets, by the box around it; `instanceId` is its index. */
  override raycast(raycaster: Raycaster, intersects: Intersection[]): void {
    localRay.copy(raycaster.ray).applyMatrix4(toLocal.copy(this.matrixWorld).invert());
    const { origin, direction } = localRay;
    direction.normalize();
    const hit = this.core.pick(origin.x, origin.y, origin.z, direction.x, direction.y, direction.z);
    if (!hit) {
      return;
    }
    const [character = 0, localDistance = 0] = hit;
    const point = localRay.at(localDistance, new Vector3()).applyMatrix4(this.matrixWorld);
    const distance = raycaster.ray.origin.distanceTo(point);
    if (distance >= raycaster.near && distance <= raycaster.far) {
      intersects.push({ distance, point, object: this, instanceId: character });
    }
  }

  /** Has everything sent to the GPU again, for a renderer that lost its context and does not do so itself. */
  invalidate(): void {
    for (const rows of [this.#palettes, this.#cached, this.#transforms, this.#weights, this.#colors]) {
      rows?.invalidate();
    }
  }

  /** Releases the crowd. The asset stays. */
  override dispose(): void {
    super.dispose();
    this.removeFromParent();
    this.#rebuild();
    for (const level of this.#levels.values()) {
      level.dispose();
    }
    this.#levels.clear();
    for (const rows of [this.#palettes, this.#cached, this.#transforms, this.#weights, this.#colors]) {
      rows?.dispose();
    }
    this.core.free();
  }

  /** Sends the numbers that changed. */
  #send(): void {
    const arrays = this.#arrays;
    this.#palettes.replace(arrays.palettes);
    if (this.#isMoved) {
      this.#isMoved = false;
      this.#transforms.write(arrays.transforms);
    }
    // After the defaults.
    this.#weights.write(arrays.morphWeights, this.#morphTargets);
    if (!this.#cacheIsSent && (this.core.records > 0 || this.core.stepped > 0)) {
      this.#cacheIsSent = true;
      this.#cached.write(arrays.cached);
    }
  }

  /** Shows the groups of the frame, and hides the others. */
  #show(): void {
    for (const group of this.#groups.values()) {
      group.hide();
    }
    const arrays = this.#arrays;
    const groups = arrays.groups();
    const made = groups.map((group) => this.#meshesOf(group));
    // Making meshes calls the module, after which views are made anew.
    const { draws, records, stepped } = arrays;
    const lists = { palette: draws, record: records, step: stepped, impostor: undefined };
    groups.forEach((group, i) => {
      const list = lists[group.kind];
      if (list !== undefined) {
        made[i]?.show(group, list);
      }
    });
  }

  #meshesOf(group: DrawGroup): GroupMeshes {
    const key = `${group.kind} ${group.level}`;
    let made = this.#groups.get(key);
    if (made === undefined) {
      const level = this.#level(group.level);
      const materials = level.ranges.map(({ material }) => this.#materialsOf(group, level, material));
      made = new GroupMeshes(group.kind, level, this.count, materials);
      this.#groups.set(key, made);
      this.add(...made.meshes);
    }
    for (const mesh of made.meshes) {
      mesh.castShadow = this.castShadow;
      mesh.receiveShadow = this.receiveShadow;
      mesh.renderOrder = this.renderOrder;
      mesh.layers.mask = this.layers.mask;
    }
    return made;
  }

  #level(level: number): LevelMesh {
    let made = this.#levels.get(level);
    if (made === undefined) {
      const mesh = this.core.mesh(level);
      made = new LevelMesh(mesh);
      mesh.free();
      this.#levels.set(level, made);
    }
    return made;
  }

  #materialsOf({ kind, level }: DrawGroup, mesh: LevelMesh, material: number): CrowdMaterials {
    const shape: CrowdShape = {
      blended: kind === 'record',
      palettes: kind === 'palette' ? this.#palettes : this.#cached,
      transforms: this.#transforms,
      colors: this.#colors,
      fours: mesh.fours,
      morphs: mesh.morphs,
      weights: this.#weights,
      morphTargets: this.#morphTargets,
    };
    // Levels without morph targets share shaders.
    const key = [kind, mesh.fours, mesh.morphs === undefined ? '' : level, material].join(' ');
    let made = this.#materials.get(key);
    if (made === undefined) {
      made = this.#shading.materials(this.asset.material(material), shape);
      this.#materials.set(key, made);
    }
    return made;
  }

  /** Drops meshes and materials; they are made again when they are shown. */
  #rebuild(): void {
    for (const group of this.#groups.values()) {
      group.dispose();
    }
    this.#groups.clear();
    for (const { material, depth, distance } of this.#materials.values()) {
      material.dispose();
      depth?.dispose();
      distance?.dispose();
    }
    this.#materials.clear();
  }

  #dispatch(): void {
    const { events } = this.core;
    for (let i = 0; i + EVENT_NUMBERS <= events.length; i += EVENT_NUMBERS) {
      const [character = 0, clip = 0, id = 0, weight = 0] = events.subarray(i, i + EVENT_NUMBERS);
      this.dispatchEvent({ type: 'clipevent', character, clip: this.clips[clip] ?? '', id, weight });
    }
  }
}
