import { Matrix4, type Vector3 } from 'three';

import type { Studio } from '../studio.js';
import { button, section } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import type { RecordedCamera } from '../view/camera-path.js';
import type { Viewport } from '../view/viewport.js';
import type { StageColumn } from './column.js';

/** Longest recording in seconds, and the least between two of its frames. */
const MOST_SECS = 30;
const STEP_SECS = 1 / 30;
/** Frames come a little early or late. */
const EARLY_SECS = 0.004;
const ROWS = 12;

/** What the first figure showed, frame by frame. */
interface Frames {
  readonly camera: RecordedCamera;
  /** From the space of the figure before the camera to the space where it began. */
  readonly home: Matrix4;
  readonly times: number[];
  readonly joints: number[];
  readonly morphs: number[];
}

const there = new Matrix4();
const joint = new Matrix4();

/** Records all that is shown, whatever moves it: clip, levels, metric, expressions and the camera. It becomes a clip. */
export class RecordingPanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #first: () => StageColumn | undefined;
  readonly #said = h('p', { class: 'said', role: 'status' });
  readonly #button = button('Record what is shown', () => this.#toggle());
  #frames: Frames | undefined;
  #secs = 0;
  #count = 0;

  /** `first` is the figure that is recorded. */
  constructor(studio: Studio, viewport: Viewport, first: () => StageColumn | undefined) {
    this.#studio = studio;
    this.#viewport = viewport;
    this.#first = first;
    const hint = h('p', { class: 'hint' }, 'Play, move the camera, change levels, metric and face: what is seen becomes a clip, seen by the camera as it began. Flat makes a picture of it.');
    this.element = section('Recording', false, h('div', { class: 'buttons' }, this.#button), this.#said, hint);
  }

  /** Goes on by a step of the page's clock, after the figures. */
  frame(dtSecs: number): void {
    const frames = this.#frames;
    const column = this.#first();
    if (frames === undefined || column === undefined) {
      return;
    }
    this.#secs += dtSecs;
    const last = frames.times.at(-1) ?? -1;
    if (this.#secs - last >= STEP_SECS - EARLY_SECS) {
      this.#take(frames, column);
    }
    this.#said.textContent = `Recording: ${this.#secs.toFixed(1)} s.`;
    if (this.#secs >= MOST_SECS) {
      this.#toggle();
    }
  }

  /** Forgets what is being recorded. */
  end(): void {
    this.#frames = undefined;
    this.#button.textContent = 'Record what is shown';
    this.#said.textContent = '';
  }

  #toggle(): void {
    const frames = this.#frames;
    const column = this.#first();
    if (frames !== undefined) {
      this.end();
      void this.#keep(frames);
    } else if (column !== undefined) {
      this.#secs = 0;
      this.#frames = begun(column, this.#viewport);
      this.#take(this.#frames, column);
      this.#button.textContent = 'Stop recording';
      this.#said.textContent = 'Recording.';
    }
  }

  #take(frames: Frames, column: StageColumn): void {
    const { figure } = column;
    const { camera } = this.#viewport;
    camera.updateMatrixWorld();
    figure.updateWorldMatrix(true, false);
    // The figure before the camera, as if that stood where it began.
    there.copy(camera.matrixWorld).invert().multiply(figure.matrixWorld).premultiply(frames.home);
    const rows = column.joints();
    for (let at = 0; at < rows.length; at += ROWS) {
      const of = (i: number): number => rows[at + i] ?? 0;
      joint.set(of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7), of(8), of(9), of(10), of(11), 0, 0, 0, 1).premultiply(there);
      const { elements: e } = joint.transpose();
      frames.joints.push(...e.slice(0, ROWS));
    }
    frames.morphs.push(...(figure.mesh.morphTargetInfluences ?? []));
    frames.times.push(this.#secs);
  }

  /** Makes the recording a clip of the character. */
  async #keep({ camera, times, joints, morphs }: Frames): Promise<void> {
    if (times.length < 2) {
      this.#studio.notices.fault('Nothing was recorded: play, move the camera, or change what moves.');
      return;
    }
    this.#count += 1;
    const name = `shown-${this.#count}`;
    try {
      await this.#studio.addRecording({ name, times: Float32Array.from(times), joints: Float32Array.from(joints), morphs: Float32Array.from(morphs) }, camera);
    } catch (error) {
      this.#studio.notices.fault(error);
    }
  }
}

/** A recording that begins with what is shown now. */
function begun({ figure, root }: StageColumn, { camera, controls }: Viewport): Frames {
  camera.updateMatrixWorld();
  figure.updateWorldMatrix(true, false);
  const [eye, target] = [camera.position, controls.target].map((point) => figure.worldToLocal(point.clone())) as [Vector3, Vector3];
  // The clip that it becomes is played where the figure stands, wherever a clip has carried it by now.
  const again = [eye, target].flatMap((point) => root.localToWorld(point.clone()).toArray());
  return {
    camera: { eye: eye.toArray(), target: target.toArray(), fovDeg: camera.fov, pose: again.map((x) => Number(x.toFixed(3))).join(',') },
    home: figure.matrixWorld.clone().invert().multiply(camera.matrixWorld),
    times: [],
    joints: [],
    morphs: [],
  };
}
