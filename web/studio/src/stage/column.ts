import type { ArticulaAsset } from '@articula/three';
import { ArticulaFigure } from '@articula/three';
import { Group, type Material } from 'three';

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

/** One figure with its skeleton, on the clock of the page. */
export class StageColumn {
  readonly root = new Group();
  readonly figure: ArticulaFigure;
  readonly title: string;
  readonly #overlay: SkeletonOverlay;
  readonly #asset: ArticulaAsset;
  readonly #rule: ColumnRule;
  /** Metres by which the clip carries the figure in a second. */
  #drift: readonly [number, number] = [0, 0];

  constructor(asset: ArticulaAsset, rule: ColumnRule) {
    this.#asset = asset;
    this.#rule = rule;
    this.title = rule.title;
    this.figure = new ArticulaFigure(asset);
    this.#overlay = new SkeletonOverlay([...asset.core.parents], heightOf(asset));
    this.figure.add(this.#overlay);
    this.root.add(this.figure);
  }

  /** Takes over the metric, its transitions, and the joints that may move. */
  steer(state: StudioState, rule = this.#rule): void {
    const { core } = this.figure;
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

  /** Changes the joints that may move, in a transition. */
  articulate(joints: Uint32Array): void {
    this.figure.core.articulate(joints);
  }

  /** Plays a clip on the spot: what carries the figure away is taken out. */
  play(clip: number, secs: number): void {
    this.#drift = drift(this.#asset, clip);
    this.figure.core.play(clip, secs);
  }

  /** How the body and the skeleton are shown. */
  dress(state: StudioState): void {
    this.#overlay.visible = state.skeleton;
    this.#overlay.radius = heightOf(this.#asset) * 0.008 * state.radius;
    this.figure.mesh.visible = state.body !== 'none';
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
    const { figure } = this;
    figure.position.set(-this.#drift[0] * clipSecs, 0, -this.#drift[1] * clipSecs);
    figure.updateAt(nowSecs, clipSecs, viewport.camera, viewport.columnSize);
    if (this.#overlay.visible) {
      this.#overlay.update(this.joints(), figure.core.jointStates);
    }
  }

  /** Model-space matrices of the joints. */
  joints(): Float32Array {
    const { core } = this.figure;
    return new Float32Array(this.#asset.articula.memory.buffer, core.jointsAt(), this.#asset.joints.length * MATRIX_FLOATS);
  }

  /** The palette of the last frame. */
  palette(): Float32Array {
    const { core } = this.figure;
    return new Float32Array(this.#asset.articula.memory.buffer, core.paletteAt(), this.#asset.shape().bindings * MATRIX_FLOATS);
  }

  figures(): ColumnFigures {
    const states = this.figure.core.jointStates;
    const [updated = 0, , sampled = 0, matrices = 0] = this.figure.core.work;
    const of = (state: number): number => states.reduce((sum, s) => sum + (s === state ? 1 : 0), 0);
    return { active: of(ACTIVE), passive: of(PASSIVE), changing: of(IN_TRANSITION), updated, sampled, matrices };
  }

  dispose(): void {
    this.#overlay.dispose();
    this.figure.dispose();
    this.root.removeFromParent();
  }
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
