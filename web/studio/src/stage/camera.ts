import { Vector3 } from 'three';

import { baseOf } from '../files.js';
import type { Studio } from '../studio.js';
import { button, section } from '../ui/controls.js';
import { download, h } from '../ui/dom.js';
import { type CameraKey, cameraAt, type Point, thinned, writeCameraPath } from '../view/camera-path.js';
import type { Viewport } from '../view/viewport.js';
import type { StageColumn } from './column.js';
import type { Timeline } from './timeline.js';

/** Longest recording in seconds. */
const MOST_SECS = 120;
/** Frames between two looks at a camera that the visitor moves. */
const LOOK_EVERY = 20;

/** Records how the camera is moved while the clip plays, from its start, and plays that again. */
export class CameraPanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #timeline: Timeline;
  readonly #first: () => StageColumn | undefined;
  readonly #said = h('p', { class: 'said', role: 'status' });
  readonly #record = button('Record', () => this.#toggle('record'));
  readonly #replay = button('Replay', () => this.#toggle('replay'));
  readonly #save = button('Save', () => this.#download());
  #does: 'nothing' | 'record' | 'replay' = 'nothing';
  /** Seconds of the clip since the path began. */
  #secs = 0;
  #taken: CameraKey[] = [];

  /** `first` is the figure in whose space the camera is told. */
  constructor(studio: Studio, viewport: Viewport, timeline: Timeline, first: () => StageColumn | undefined) {
    this.#studio = studio;
    this.#viewport = viewport;
    this.#timeline = timeline;
    this.#first = first;
    const hint = h('p', { class: 'hint' }, 'Begins with the clip. The file is that of articula lod --camera-path; drop one to replay it.');
    this.element = section('Camera path', false, h('div', { class: 'buttons' }, this.#record, this.#replay, this.#save), this.#said, hint);
    // A path that was dropped on another page is shown by the page that is made for it.
    const open = (): void => {
      this.element.toggleAttribute('open', true);
      this.renew();
    };
    studio.addEventListener('camera-path', open);
    if (studio.cameraPath.length > 0) {
      open();
    }
    viewport.controls.addEventListener('start', () => {
      if (this.#does === 'replay') {
        this.end();
      }
    });
    this.renew();
  }

  /** Ends what is recorded or replayed. */
  end(): void {
    if (this.#does === 'record') {
      this.#studio.cameraPath = thinned(this.#taken);
      this.#taken = [];
    }
    this.#does = 'nothing';
    this.#viewport.controls.enabled = true;
    this.renew();
  }

  /** Says what there is. */
  renew(): void {
    const { cameraPath } = this.#studio;
    const is = (what: string): boolean => this.#does === what;
    this.#record.textContent = is('record') ? 'Stop recording' : 'Record';
    this.#replay.textContent = is('replay') ? 'Stop' : 'Replay';
    this.#record.disabled = is('replay');
    this.#replay.disabled = is('record') || cameraPath.length === 0;
    this.#save.disabled = is('record') || cameraPath.length === 0;
    const secs = (cameraPath.at(-1)?.t ?? 0) - (cameraPath[0]?.t ?? 0);
    this.#said.textContent = is('record')
      ? 'Recording: move the camera.'
      : cameraPath.length === 0
        ? 'No path yet.'
        : `${cameraPath.length} ${cameraPath.length === 1 ? 'key' : 'keys'} over ${secs.toFixed(2)} s.`;
  }

  /** Goes on by a step of the page's clock, after the timeline and before the figures. */
  frame(dtSecs: number): void {
    const column = this.#first();
    if (this.#does === 'nothing' || column === undefined) {
      this.#look();
      return;
    }
    const { playing, speed } = this.#studio.state;
    const path = this.#studio.cameraPath;
    this.#secs += playing ? dtSecs * speed : 0;
    if (this.#does === 'replay') {
      const key = cameraAt(path, this.#secs);
      this.#show(column, key);
      if (this.#secs >= (path.at(-1)?.t ?? 0) || !playing) {
        this.end();
      }
      return;
    }
    this.#taken.push(this.#seen(column));
    if (!playing || this.#secs >= MOST_SECS) {
      this.end();
    }
  }

  #toggle(what: 'record' | 'replay'): void {
    if (this.#does !== 'nothing') {
      this.end();
      return;
    }
    this.#does = what;
    this.#secs = what === 'replay' ? (this.#studio.cameraPath[0]?.t ?? 0) : 0;
    this.#viewport.leave();
    this.#viewport.controls.enabled = what === 'record';
    this.#timeline.restart(this.#secs);
    const column = this.#first();
    if (what === 'record' && column !== undefined) {
      this.#taken = [this.#seen(column)];
    }
    this.renew();
  }

  /** The camera in the space of the character. */
  #seen(column: StageColumn): CameraKey {
    const { camera, controls } = this.#viewport;
    column.place(this.#timeline.secs);
    const local = (point: Vector3): Point => column.figure.worldToLocal(point.clone()).toArray();
    return { t: this.#secs, eye: local(camera.position), target: local(controls.target) };
  }

  #show(column: StageColumn, key: CameraKey | undefined): void {
    if (key === undefined) {
      return;
    }
    const { camera, controls } = this.#viewport;
    column.place(this.#timeline.secs);
    controls.target.copy(column.figure.localToWorld(new Vector3(...key.target)));
    camera.position.copy(column.figure.localToWorld(new Vector3(...key.eye)));
    camera.lookAt(controls.target);
  }

  /** Keeps the camera that the visitor has moved, for the link. */
  #look(): void {
    const { frames, isFitted, pose } = this.#viewport;
    if (!isFitted && frames % LOOK_EVERY === 0 && pose !== this.#studio.state.camera) {
      this.#studio.set({ camera: pose });
    }
  }

  #download(): void {
    const base = baseOf(this.#studio.character.name);
    download(writeCameraPath(this.#studio.cameraPath), `${base}-camera.json`, 'application/json');
  }
}
