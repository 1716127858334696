import { section } from '../ui/controls.js';
import { Course } from '../ui/course.js';
import { Readout } from '../ui/status.js';
import type { ColumnFigures } from './column.js';

/** Frames that the plot shows. */
const KEPT = 240;
/** Frames between two renewals of the words. */
const EVERY = 6;

/** Figures of the frame: joints by state, work, error and time, and their course. */
export class LivePanel {
  readonly element: HTMLElement;
  readonly #readout = new Readout();
  readonly #course = new Course({
    label: 'Joints updated and error in pixels over the last frames',
    lines: ['joints updated', 'error, px'],
    least: [1, 0.5],
    kept: KEPT,
  });
  #ms = 0;
  #frame = 0;

  constructor() {
    this.element = section('This frame', true, this.#readout.element, this.#course.element);
  }

  /** Takes over a frame of the first column. */
  update(figures: ColumnFigures, column: string | undefined, joints: number, [p95, worst]: readonly [number, number], ms: number): void {
    this.#ms += (ms - this.#ms) * 0.1;
    this.#course.add(figures.updated, p95);
    this.#frame += 1;
    if (this.#frame % EVERY !== 1) {
      return;
    }
    this.#readout.set('Column', column);
    this.#readout.set('Joints updated', `${figures.updated} of ${joints}`);
    this.#readout.set('Updates saved', `${joints === 0 ? 0 : Math.round((100 * (joints - figures.updated)) / joints)} %`);
    this.#readout.set('Error, 95 % of the skin', `${p95.toFixed(2)} px`);
    this.#readout.set('Error, worst vertex', `${worst.toFixed(2)} px`);
    this.#readout.set('Transforms sampled', `${figures.sampled}`);
    this.#readout.set('Matrices computed', `${figures.matrices}`);
    this.#readout.set('Evaluation', `${this.#ms.toFixed(3)} ms`);
    this.#course.draw();
  }
}
