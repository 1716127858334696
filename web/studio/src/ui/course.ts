import 'uplot/dist/uPlot.min.css';

import type uPlot from 'uplot';

import { h } from './dom.js';

/** Height of a plot in pixels of the page. */
const HEIGHT = 110;

export interface CourseOptions {
  /** What it shows, for those who do not see it. */
  readonly label: string;
  /** Names of the two lines, the left and the right one. */
  readonly lines: readonly [string, string];
  /** What the two scales reach at least. */
  readonly least: readonly [number, number];
  /** Values that are shown. */
  readonly kept: number;
}

/** Two values over the last moments, each with a scale of its own. The plotter is loaded when one is made. */
export class Course {
  readonly element: HTMLElement;
  readonly #options: CourseOptions;
  readonly #plotted: HTMLElement;
  readonly #values: readonly [number[], number[]];
  readonly #index: number[];
  #plot: uPlot | undefined;

  constructor(options: CourseOptions) {
    const { label, lines, kept } = options;
    this.#options = options;
    this.#values = [new Array<number>(kept).fill(0), new Array<number>(kept).fill(0)];
    this.#index = Array.from({ length: kept }, (_, i) => i - kept + 1);
    this.#plotted = h('div', { class: 'plot', role: 'img', 'aria-label': label });
    const key = (kind: string, text: string): HTMLElement => h('li', { class: kind }, text);
    const legend = h('ul', { class: 'plot-key' }, key('line-joints', lines[0]), key('line-error', lines[1]));
    this.element = h('div', {}, legend, this.#plotted);
    void this.#make();
    // Colours of the theme are read when it is drawn.
    const renew = (): void => void requestAnimationFrame(() => this.#plot?.redraw());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', renew);
    addEventListener('themechange', renew);
  }

  /** Takes over two values; they are shown with the next {@link draw}. */
  add(left: number, right: number): void {
    [left, right].forEach((value, line) => {
      this.#values[line as 0 | 1].push(value);
      this.#values[line as 0 | 1].shift();
    });
  }

  draw(): void {
    this.#plot?.setData([this.#index, ...this.#values]);
  }

  /** Forgets all values. */
  clear(): void {
    this.#values.forEach((values) => values.fill(0));
    this.draw();
  }

  async #make(): Promise<void> {
    const { default: Plot } = await import('uplot');
    const color = (name: string) => () => getComputedStyle(this.element).getPropertyValue(name);
    const axis = { stroke: color('--muted'), grid: { stroke: color('--line'), width: 1 }, ticks: { show: false }, font: '11px system-ui', size: 34 };
    const width = (): number => Math.max(this.#plotted.clientWidth, 200);
    const [left, right] = this.#options.least;
    this.#plot = new Plot(
      {
        width: width(),
        height: HEIGHT,
        cursor: { show: false },
        legend: { show: false },
        scales: { x: { time: false }, right: { range: (_, __, most) => [0, Math.max(most, right)] }, y: { range: (_, __, most) => [0, Math.max(most, left)] } },
        axes: [{ show: false }, { ...axis, scale: 'y' }, { ...axis, scale: 'right', side: 1, grid: { show: false } }],
        series: [{}, { stroke: color('--series-1'), width: 2, points: { show: false } }, { scale: 'right', stroke: color('--series-2'), width: 2, points: { show: false } }],
      },
      [this.#index, ...this.#values],
      this.#plotted,
    );
    new ResizeObserver(() => this.#plot?.setSize({ width: width(), height: HEIGHT })).observe(this.#plotted);
  }
}
