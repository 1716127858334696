import { button, section, slider, type Control } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import type { Studio } from '../studio.js';
import type { StageColumn } from './column.js';
import { FaceRecording } from './face-recording.js';

/** Sliders of the expressions of the file, where it has any. */
export class FacePanel {
  readonly element: HTMLDetailsElement;
  readonly #studio: Studio;
  readonly #columns: () => readonly StageColumn[];
  readonly #body = h('div', { class: 'stack' });
  readonly #list = h('div', { class: 'stack sliders', tabindex: 0, role: 'region', 'aria-label': 'Expressions' });
  readonly #weights = new Map<string, number>();
  readonly #record = button('Record', () => this.#toggle(), 'small');
  #recording: FaceRecording | undefined;
  #recordings = 0;
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
    this.#end();
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
    const hint = h('p', { class: 'hint' }, 'What is recorded becomes a clip of the face, which Flat makes a picture of too.');
    this.#body.replaceChildren(this.#list, h('div', { class: 'buttons' }, clear, this.#record), hint);
  }

  /** Goes on by a step of the page's clock. */
  frame(dtSecs: number): void {
    if (this.#recording?.take(dtSecs, this.#weights) === false) {
      this.#toggle();
    }
  }

  /** Begins a recording, or ends it and makes it a clip of the character. */
  #toggle(): void {
    const recording = this.#recording;
    if (recording === undefined) {
      this.#recording = new FaceRecording();
      this.#record.textContent = 'Stop recording';
      return;
    }
    this.#end();
    if (recording.length < 2) {
      this.#studio.notices.fault('Nothing was recorded: play, and move an expression.');
      return;
    }
    this.#recordings += 1;
    void this.#studio.open(new File([recording.csv()], `recorded-${this.#recordings}.csv`, { type: 'text/csv' }));
  }

  #end(): void {
    this.#recording = undefined;
    this.#record.textContent = 'Record';
  }

  /** Sets the weights on all columns. */
  apply(): void {
    for (const figure of this.#columns().flatMap(({ crew }) => crew)) {
      this.#weights.forEach((weight, name) => figure.setExpression(name, weight));
    }
  }
}
