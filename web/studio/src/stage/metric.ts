import { section, segmented, slider, type Control } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';

const power = (exponent: number): number => 10 ** exponent;
const scientific = (value: number): string => value.toExponential(1);

/** What chooses among the joints that may move, and how they change their state. */
export class MetricPanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #pixels: Control<number>;
  readonly #thesis: HTMLElement;
  readonly #note = h('p', { class: 'hint' });

  constructor(studio: Studio) {
    this.#studio = studio;
    const { state } = studio;
    const set = (change: Partial<StudioState>): void => studio.set(change);
    const metric = segmented('Metric', [['none', 'None'], ['pixels', 'Pixel error'], ['thesis', 'Threshold']], state.metric, (word) => {
      set({ metric: word as StudioState['metric'] });
      this.renew();
    });
    this.#pixels = slider({
      label: 'Tolerance',
      min: -1.3,
      max: 1.8,
      step: 0.05,
      value: Math.log10(state.pixels),
      shown: (x) => `${power(x).toPrecision(2)} px`,
      onInput: (x) => set({ pixels: Number(power(x).toPrecision(2)) }),
    });
    const threshold = slider({
      label: 'Threshold at the viewer',
      min: -6,
      max: 0,
      step: 0.1,
      value: Math.log10(state.threshold),
      shown: (x) => scientific(power(x)),
      onInput: (x) => set({ threshold: Number(scientific(power(x))) }),
    });
    const farthest = slider({
      label: 'Threshold at 16 m',
      min: -6,
      max: 0,
      step: 0.1,
      value: Math.log10(state.farthest),
      shown: (x) => scientific(power(x)),
      onInput: (x) => set({ farthest: Number(scientific(power(x))) }),
    });
    const curve = segmented('Between them', [['literal', 'As printed'], ['fixed', 'Rising']], state.curve, (word) => set({ curve: word as StudioState['curve'] }));
    const lookup = slider({ label: 'Look-up', min: 1, max: 60, step: 1, value: state.lookup, shown: (n) => (n === 1 ? 'every frame' : `every ${n} frames`), onInput: (n) => set({ lookup: n }) });
    const beta = slider({
      label: 'Orientation against velocity (β)',
      min: 0,
      max: 1,
      step: 0.05,
      value: state.beta,
      shown: (b) => b.toFixed(2),
      hint: 'What an error is: 1 counts how far a joint turns, 0 how its turning changes. Files store the errors of 0.50; others are found in a worker.',
      onInput: (b) => set({ beta: b }),
    });
    this.#thesis = h('div', { class: 'stack' }, threshold.element, farthest.element, curve.element, lookup.element, beta.element);
    const transition = slider({ label: 'Transition', min: 0, max: 2, step: 0.05, value: state.transition, shown: (s) => (s === 0 ? 'none' : `${Math.round(1000 * s)} ms`), onInput: (s) => set({ transition: s }) });
    const ease = segmented('Course', [['smooth', 'Smooth'], ['linear', 'Linear']], state.ease, (word) => set({ ease: word as StudioState['ease'] }));
    const passive = segmented('Passive joints show', [['hold', 'Last pose'], ['rest', 'Rest pose']], state.passive, (word) => set({ passive: word as StudioState['passive'] }));
    this.element = section('Metric and transitions', true, metric.element, this.#note, this.#pixels.element, this.#thesis, transition.element, ease.element, passive.element);
    this.renew();
  }

  renew(): void {
    const { metric } = this.#studio.state;
    this.#pixels.element.hidden = metric !== 'pixels';
    this.#thesis.hidden = metric !== 'thesis';
    const has = this.#studio.character.asset.core.isPrepared;
    const missing = metric !== 'none' && !has ? ' This file has no tables yet, so all joints move until they are made.' : '';
    this.#note.textContent =
      (metric === 'none'
        ? 'The level alone decides.'
        : metric === 'pixels'
          ? 'Of the joints that may move, each shows the coarsest of its stored keys whose error stays below the tolerance in this view.'
          : 'Of the joints that may move, each is held while its stored error is below a threshold that depends on the distance.') + missing;
  }
}
