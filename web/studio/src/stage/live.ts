import 'uplot/dist/uPlot.min.css';

import type uPlot from 'uplot';

import { section } from '../ui/controls.js';
import { h } from '../ui/dom.js';
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
  readonly #plotted = h('div', { class: 'plot', role: 'img', 'aria-label': 'Joints updated and error in pixels over the last frames' });
  readonly #joints: number[] = new Array<number>(KEPT).fill(0);
  readonly #errors: number[] = new Array<number>(KEPT).fill(0);
  readonly #index = Array.from({ length: KEPT }, (_, i) => i - KEPT + 1);
  #plot: uPlot | undefined;
  #ms = 0;
  #frame = 0;

  constructor() {
    const key = (kind: string, text: string): HTMLElement => h('li', { class: kind }, text);
    const legend = h('ul', { class: 'plot-key' }, key('line-joints', 'joints updated'), key('line-error', 'error, px'));
    this.element = section('This frame', true, this.#readout.element, legend, this.#plotted);
    void this.#makePlot();
  }

  /** Takes over a frame of the first column. */
  update(figures: ColumnFigures, column: string | undefined, joints: number, [p95, worst]: readonly [number, number], ms: number): void {
    this.#ms += (ms - this.#ms) * 0.1;
    this.#joints.push(figures.updated);
    this.#errors.push(p95);
    this.#joints.shift();
    this.#errors.shift();
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
    this.#plot?.setData([this.#index, this.#joints, this.#errors]);
  }

  async #makePlot(): Promise<void> {
    const { default: Plot } = await import('uplot');
    const color = (name: string) => () => getComputedStyle(this.element).getPropertyValue(name);
    const axis = { stroke: color('--muted'), grid: { stroke: color('--line'), width: 1 }, ticks: { show: false }, font: '11px system-ui', size: 34 };
    const width = (): number => Math.max(this.#plotted.clientWidth, 200);
    this.#plot = new Plot(
      {
        width: width(),
        height: 110,
        cursor: { show: false },
        legend: { show: false },
        scales: { x: { time: false }, px: { range: (_, __, most) => [0, Math.max(most, 0.5)] }, y: { range: (_, __, most) => [0, Math.max(most, 1)] } },
        axes: [{ show: false }, { ...axis, scale: 'y' }, { ...axis, scale: 'px', side: 1, grid: { show: false } }],
        series: [{}, { stroke: color('--series-1'), width: 2, points: { show: false } }, { scale: 'px', stroke: color('--series-2'), width: 2, points: { show: false } }],
      },
      [this.#index, this.#joints, this.#errors],
      this.#plotted,
    );
    new ResizeObserver(() => this.#plot?.setSize({ width: width(), height: 110 })).observe(this.#plotted);
  }
}
