import type { ArticulaAsset } from '@articula/three';
import { ArticulaFigure } from '@articula/three';
import { Color, Group, type Material } from 'three';

import type { StudioState } from '../state.js';
import { ACTIVE, IN_TRANSITION, PASSIVE, SkeletonOverlay } from '../view/skeleton.js';
import type { Viewport } from '../view/viewport.js';

const MATRIX_FLOATS = 12;
const NO_VIEW = new Float32Array(0);

/** What decides which joints of a column move. */
export interface ColumnRule {
  readonly title: string;
  /** Joints that may move. */
  readonly joints: Uint32Array;
  /** Whether the metric of the state chooses among them. */
  readonly measured: boolean;
}

/** Counts of a frame. */
export interface ColumnFigures {
  readonly active: number;
  readonly passive: number;
  readonly changing: number;
  readonly updated: number;
  readonly sampled: number;
  readonly matrices: number;
}

/** Share of a clip by which each clone is ahead of the one before. */
const AHEAD = 0.37;
/** Where clones stand, in heights of the character: beside it in turns, each pair farther behind. */
const BESIDE = 0.5;
const BEHIND = 0.35;

/** By how much wider a figure with so many clones is than alone, by its height. */
export function widthOf(clones: number): number {
  return 2 * Math.ceil(clones / 2) * BESIDE;
}

/** One figure with its skeleton, and its clones, on the clock of the page. */
export class StageColumn {
  readonly root = new Group();
  readonly figure: ArticulaFigure;
  /** The figure and its clones, which share its geometry. */
  readonly crew: readonly ArticulaFigure[];
  readonly title: string;
  readonly #overlays: readonly SkeletonOverlay[];
  readonly #asset: ArticulaAsset;
  readonly #rule: ColumnRule;
  /** Metres by which the clip carries the figure in a second. */
  #drift: readonly [number, number] = [0, 0];
  #clipSecs = 0;
  /** Transforms and matrices of the last frame that had any, or in which the clip went on. */
  #work: readonly [number, number] = [0, 0];
  #shownSecs = Number.NaN;

  constructor(asset: ArticulaAsset, rule: ColumnRule, clones = 0) {
    this.#asset = asset;
    this.#rule = rule;
    this.title = rule.title;
    this.figure = new ArticulaFigure(asset);
    this.crew = [this.figure, ...Array.from({ length: clones }, () => new ArticulaFigure(asset))];
    this.#overlays = this.crew.map((figure) => {
      const overlay = new SkeletonOverlay([...asset.core.parents], heightOf(asset));
      figure.add(overlay);
      return overlay;
    });
    this.root.add(...this.crew);
  }

  /** Takes over the metric, its transitions, and the joints that may move. */
  steer(state: StudioState, rule = this.#rule): void {
    for (const { core } of this.crew) {
      steered(core, state, rule);
    }
  }

  /** Sets the errors of a clip by which thresholds decide; without, those of the file. */
  weigh(clip: number, errors: Float32Array | undefined): void {
    this.crew.forEach(({ core }) => core.setErrors(clip, errors));
  }

  /** Changes the joints that may move, in a transition. */
  articulate(joints: Uint32Array): void {
    this.crew.forEach(({ core }) => core.articulate(joints));
  }

  /** Plays a clip on the spot: what carries the figure away is taken out, unless it `travels`. */
  play(clip: number, secs: number, travels = false): void {
    this.#drift = travels ? [0, 0] : drift(this.#asset, clip);
    this.#clipSecs = this.#asset.clipSecs[clip] ?? 0;
    this.crew.forEach(({ core }, i) => core.play(clip, this.#ahead(secs, i)));
  }

  /** Where it stands. */
  stand(state: StudioState): void {
    this.root.position.set(state.across, 0, state.nearer);
    this.root.rotation.y = (state.turn * Math.PI) / 180;
  }

  /** How the body and the skeleton are shown. */
  dress(state: StudioState): void {
    const colors = [state.passiveColor, state.activeColor, state.changingColor].map((color) => new Color(color));
    this.#overlays.forEach((overlay) => {
      overlay.colors = colors;
      overlay.visible = state.skeleton;
      overlay.radius = heightOf(this.#asset) * 0.008 * state.radius;
    });
    this.crew.forEach(({ mesh }) => {
      mesh.visible = state.body !== 'none';
    });
    // All figures of an asset have the same materials.
    for (const material of this.figure.mesh.material as Material[]) {
      const clear = state.body === 'clear' && state.skeleton;
      if (material.userData.wasClear === undefined) {
        material.userData = { ...material.userData, wasClear: material.transparent, wasOpacity: material.opacity };
      }
      material.transparent = clear || (material.userData.wasClear as boolean);
      material.opacity = (clear ? 0.62 : 1) * (material.userData.wasOpacity as number);
      material.needsUpdate = true;
    }
  }

  /** Shows a moment. */
  update(nowSecs: number, clipSecs: number, viewport: Viewport): void {
    this.place(clipSecs);
    this.crew.forEach((figure, i) => {
      figure.updateAt(nowSecs, this.#ahead(clipSecs, i), viewport.camera, viewport.columnSize);
      const overlay = this.#overlays[i];
      if (overlay?.visible) {
        overlay.update(this.joints(figure), figure.core.jointStates);
      }
    });
    this.#count(clipSecs);
  }

  /** Places the figures as they stand at a time of the clip. */
  place(clipSecs: number): void {
    const height = heightOf(this.#asset);
    this.crew.forEach((figure, i) => {
      const secs = this.#ahead(clipSecs, i);
      const [pair, side] = [Math.ceil(i / 2), i % 2 === 0 ? 1 : -1];
      figure.position.set(side * pair * BESIDE * height - this.#drift[0] * secs, 0, -pair * BEHIND * height - this.#drift[1] * secs);
    });
  }

  /** Model-space matrices of the joints. */
  joints({ core } = this.figure): Float32Array {
    return new Float32Array(this.#asset.articula.memory.buffer, core.jointsAt(), this.#asset.joints.length * MATRIX_FLOATS);
  }

  /** The palette of the last frame. */
  palette(): Float32Array {
    const { core } = this.figure;
    return new Float32Array(this.#asset.articula.memory.buffer, core.paletteAt(), this.#asset.shape().bindings * MATRIX_FLOATS);
  }

  figures(): ColumnFigures {
    const states = this.figure.core.jointStates;
    const [updated = 0] = this.figure.core.work;
    const [sampled, matrices] = this.#work;
    const of = (state: number): number => states.reduce((sum, s) => sum + (s === state ? 1 : 0), 0);
    return { active: of(ACTIVE), passive: of(PASSIVE), changing: of(IN_TRANSITION), updated, sampled, matrices };
  }

  dispose(): void {
    this.#overlays.forEach((overlay) => overlay.dispose());
    this.crew.forEach((figure) => figure.dispose());
    this.root.removeFromParent();
  }

  /** Takes over what a frame took; one that shows the same again computes no matrices. */
  #count(clipSecs: number): void {
    const [, , sampled = 0, matrices = 0] = this.figure.core.work;
    if (clipSecs !== this.#shownSecs || matrices > 0) {
      this.#work = [sampled, matrices];
    }
    this.#shownSecs = clipSecs;
  }

  /** The time that a figure of the crew is at. */
  #ahead(secs: number, i: number): number {
    return i === 0 || this.#clipSecs === 0 ? secs : (secs + AHEAD * i * this.#clipSecs) % this.#clipSecs;
  }
}

/** Gives a figure its metric, its transitions, and the joints that may move. */
function steered(core: ArticulaFigure['core'], state: StudioState, rule: ColumnRule): void {
  core.setTransition(state.transition, state.ease, state.passive);
  if (rule.measured && state.metric === 'pixels') {
    core.setTolerance(state.pixels);
  } else if (rule.measured && state.metric === 'thesis') {
    core.setThreshold(state.threshold, state.farthest, 16, state.lookup, state.curve === 'fixed');
  } else {
    core.setFullDetail();
  }
  core.articulate(rule.joints);
}

/** Height of a character at rest in metres, of what has none a little. */
export function heightOf(asset: ArticulaAsset): number {
  return Math.max(asset.bounds.max.y - asset.bounds.min.y, 0.2);
}

const drifts = new WeakMap<ArticulaAsset, Map<number, readonly [number, number]>>();

/** How a clip carries its figure over the ground, metres a second in x and z. */
function drift(asset: ArticulaAsset, clip: number): readonly [number, number] {
  const known = drifts.get(asset) ?? new Map<number, readonly [number, number]>();
  drifts.set(asset, known);
  const found = known.get(clip);
  if (found !== undefined) {
    return found;
  }
  const secs = asset.clipSecs[clip] ?? 0;
  const { figure } = asset.articula.figure(asset.core);
  const place = (at: number): [number, number] => {
    figure.play(clip, at);
    figure.frame(0, NO_VIEW);
    const root = new Float32Array(asset.articula.memory.buffer, figure.jointsAt(), asset.joints.length * MATRIX_FLOATS);
    return [root[3] ?? 0, root[11] ?? 0];
  };
  const [x0, z0] = place(0);
  const [x1, z1] = place(secs * 0.9999);
  figure.free();
  // A sway is not a way: under a tenth of a metre the figure stays where it is.
  const moved = Math.hypot(x1 - x0, z1 - z0) > 0.1 && secs > 0;
  const made: readonly [number, number] = moved ? [(x1 - x0) / secs, (z1 - z0) / secs] : [0, 0];
  known.set(clip, made);
  return made;
}
