import { type CrowdOptions as CoreOptions, type Crowd, type CrowdArrays, type DrawGroup, MATRIX_FLOATS } from '@articula/core';
import {
  type BufferGeometry,
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
import { DRAW_WORDS, GroupMeshes, LevelMesh } from './crowd-mesh.js';
import { CrowdRoles } from './crowd-roles.js';
import type { CrowdMaterials, CrowdShading, CrowdShape } from './crowd-shading.js';
import { CrowdVariants } from './crowd-variants.js';
import { DataRows } from './data-rows.js';
import type { ArticulaImpostors } from './impostors.js';

/** How a crowd is made. */
export interface CrowdOptions extends Omit<CoreOptions, 'impostors'> {
  /** Pictures that show who is far enough away, unless `setPoseCache('none')` forbids it. The caller disposes of them. */
  readonly impostors?: ArticulaImpostors;
}

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
  readonly #impostors: ArticulaImpostors | undefined;
  readonly #roles: CrowdRoles;
  readonly #variants: CrowdVariants;
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
  /** The first and the last character that moved since they were sent. */
  #moved: [number, number] | undefined;
  #hears = false;

  constructor(asset: ArticulaAsset, count: number, shading: CrowdShading, options: CrowdOptions = {}) {
    super();
    const { impostors, ...rest } = options;
    const told = impostors === undefined ? rest : { ...rest, impostors: impostors.table };
    const { crowd, arrays } = asset.articula.crowd(asset.core, count, told);
    this.asset = asset;
    this.name = asset.name;
    this.count = count;
    this.core = crowd;
    this.clips = crowd.clips;
    this.warnings = crowd.warnings;
    this.#arrays = arrays;
    this.#shading = shading;
    this.#impostors = impostors;
    this.#roles = new CrowdRoles(crowd);
    this.#variants = new CrowdVariants(asset.variants, asset.name, count);
    this.#travels = options.rootMotion === 'extracted';
    const defaults = asset.core.morphDefaults;
    this.#morphTargets = defaults.length;
    this.#weights.write(defaults);
    this.#move(0, count - 1);
  }

  /** Places a character: x, y, z in metres and the turn about +Y in radians, in the space of the crowd. */
  place(character: number, x: number, y: number, z: number, yaw = 0): this {
    this.core.place(character, x, y, z, yaw);
    this.#move(character, character);
    return this;
  }

  /** Places a character with any rotation, and scale if given. */
  setTransform(character: number, position: Vector3, rotation: Quaternion, scale?: number): this {
    const { x, y, z } = position;
    this.core.setTransform(character, x, y, z, rotation.x, rotation.y, rotation.z, rotation.w);
    if (scale !== undefined) {
      this.core.setScale(character, scale);
    }
    this.#move(character, character);
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

  /** 1 is usual, 2 halves the error that a character may have. That of its role is multiplied by it. */
  setImportance(character: number, importance: number): this {
    this.#roles.setImportance(character, importance);
    return this;
  }

  /** Names of the roles, with their importance: `main`, `secondary`, `audience`, and those that were added. */
  get roles(): ReadonlyMap<string, number> {
    return this.#roles.roles;
  }

  /** Changes the importance of a role, or adds it. */
  setRole(name: string, importance: number): this {
    this.#roles.setRole(name, importance);
    return this;
  }

  /** Gives a character a role, or takes it. */
  setRoleAt(character: number, name: string | undefined): this {
    this.#roles.setRoleAt(character, name);
    return this;
  }

  /** The role of a character, if it has one. */
  roleOf(character: number): string | undefined {
    return this.#roles.of(character);
  }

  /** Who blends poses of the cache: the processor, or shaders, which then get 16 bytes a character, and more triangles. */
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

  /** Shows a character with a variant of the file's materials, one of `asset.variants`, or as usual. */
  setVariantAt(character: number, name: string | undefined): this {
    this.#variants.set(character, name);
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
      this.#move(0, this.count - 1);
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

  #move(first: number, last: number): void {
    const [least, most] = this.#moved ?? [first, last];
    this.#moved = [Math.min(least, first), Math.max(most, last)];
  }

  /** Sends the numbers that changed. */
  #send(): void {
    const arrays = this.#arrays;
    this.#palettes.share(this.asset.articula.memory, arrays.palettes);
    if (this.#moved !== undefined) {
      const [first, last] = this.#moved;
      this.#moved = undefined;
      this.#transforms.write(arrays.transforms.subarray(first * MATRIX_FLOATS, (last + 1) * MATRIX_FLOATS), first * MATRIX_FLOATS);
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
    const made = groups.map((group) => this.#partsOf(group));
    // Making meshes calls the module, after which views are made anew.
    groups.forEach((group, i) => {
      const list = this.#listOf(group.kind);
      for (const { meshes, which } of made[i] ?? []) {
        meshes.show(group, list, which);
      }
    });
  }

  /** The meshes of a group, for each variant that its characters show. */
  #partsOf(group: DrawGroup): { meshes: GroupMeshes; which: readonly number[] | undefined }[] {
    const { kind, first, count } = group;
    const words = DRAW_WORDS[kind];
    // The pictures of impostors have no variants.
    const list = kind === 'impostor' ? undefined : this.#listOf(kind);
    const split = list && this.#variants.split(list.subarray(first * words.count, (first + count) * words.count), words);
    if (split === undefined) {
      return [{ meshes: this.#meshesOf(group, -1), which: undefined }];
    }
    return [...split].map(([variant, which]) => ({ meshes: this.#meshesOf(group, variant), which }));
  }

  #listOf(kind: DrawGroup['kind']): Uint32Array {
    const { draws, records, stepped, impostors } = this.#arrays;
    return { palette: draws, record: records, step: stepped, impostor: impostors }[kind];
  }

  #meshesOf(group: DrawGroup, variant: number): GroupMeshes {
    const key = `${group.kind} ${group.level} ${variant}`;
    let made = this.#groups.get(key);
    if (made === undefined) {
      made = this.#makeMeshes(group, variant);
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

  #makeMeshes(group: DrawGroup, variant: number): GroupMeshes {
    const { kind } = group;
    if (kind === 'impostor') {
      const { geometry, materials } = this.#square();
      const ranges = [{ material: -1, isJoined: false, start: 0, count: Number.POSITIVE_INFINITY }];
      return new GroupMeshes(kind, { geometry, ranges, morphs: undefined }, this.count, [materials]);
    }
    const level = this.#level(group.level);
    const materials = level.ranges.map(({ material, isJoined }) =>
      this.#materialsOf(group, level, this.asset.materialOf(material, variant), isJoined),
    );
    return new GroupMeshes(kind, level, this.count, materials);
  }

  /** What impostors are drawn by. */
  #square(): { geometry: BufferGeometry; materials: CrowdMaterials } {
    const impostors = this.#impostors as ArticulaImpostors;
    let materials = this.#materials.get('impostor');
    if (materials === undefined) {
      const places = { transforms: this.#transforms, colors: this.#colors };
      materials = this.#shading.impostors(impostors.material, impostors.shape, places);
      this.#materials.set('impostor', materials);
    }
    return { geometry: impostors.geometry(), materials };
  }

  #level(level: number): LevelMesh {
    let made = this.#levels.get(level);
    if (made === undefined) {
      const mesh = this.core.mesh(level);
      made = new LevelMesh(mesh, (material) => this.asset.material(material).color);
      mesh.free();
      this.#levels.set(level, made);
    }
    return made;
  }

  #materialsOf({ kind, level }: DrawGroup, mesh: LevelMesh, material: number, isJoined: boolean): CrowdMaterials {
    const shape: CrowdShape = {
      blended: kind === 'record',
      coloredByVertices: isJoined,
      palettes: kind === 'palette' ? this.#palettes : this.#cached,
      transforms: this.#transforms,
      colors: this.#colors,
      fours: mesh.fours,
      morphs: mesh.morphs,
      weights: this.#weights,
      morphTargets: this.#morphTargets,
    };
    // Levels without morph targets share shaders.
    const key = [kind, mesh.fours, mesh.morphs === undefined ? '' : level, material, isJoined].join(' ');
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
