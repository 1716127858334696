import { button, section, slider, type Control } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import type { Studio } from '../studio.js';
import type { StageColumn } from './column.js';

/** Sliders of the expressions of the file, where it has any. */
export class FacePanel {
  readonly element: HTMLDetailsElement;
  readonly #studio: Studio;
  readonly #columns: () => readonly StageColumn[];
  readonly #body = h('div', { class: 'stack' });
  readonly #list = h('div', { class: 'stack sliders', tabindex: 0, role: 'region', 'aria-label': 'Expressions' });
  readonly #weights = new Map<string, number>();
  #sliders: Control<number>[] = [];

  constructor(studio: Studio, columns: () => readonly StageColumn[]) {
    this.#studio = studio;
    this.#columns = columns;
    this.element = section('Face', false, this.#body);
  }

  renew(): void {
    const { expressions } = this.#studio.character.asset;
    this.element.hidden = expressions.length === 0;
    this.#weights.clear();
    this.#sliders = expressions.map((name) =>
      slider({
        label: name,
        min: 0,
        max: 1,
        step: 0.01,
        value: 0,
        shown: (weight) => `${Math.round(100 * weight)} %`,
        onInput: (weight) => {
          this.#weights.set(name, weight);
          this.apply();
        },
      }),
    );
    const clear = button('Clear', () => {
      this.#weights.clear();
      this.#sliders.forEach((control) => control.set(0));
      this.#columns().forEach(({ crew }) => crew.forEach((figure) => figure.clearMorphs()));
    }, 'small');
    this.#list.replaceChildren(...this.#sliders.map(({ element }) => element));
    this.#body.replaceChildren(this.#list, clear);
  }

  /** Sets the weights on all columns. */
  apply(): void {
    for (const figure of this.#columns().flatMap(({ crew }) => crew)) {
      this.#weights.forEach((weight, name) => figure.setExpression(name, weight));
    }
  }
}
