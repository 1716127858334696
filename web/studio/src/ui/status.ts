import type { Progress } from '@articula/core';

import { button, type Control } from './controls.js';
import { h } from './dom.js';

/** A line about what takes long, with a bar and a way to end it. */
export class TaskLine {
  readonly element: HTMLElement;
  readonly #text = h('span', { class: 'task-text' });
  readonly #bar = h('progress', { 'aria-label': 'Progress' });
  #abort: AbortController | undefined;

  constructor() {
    const stop = button('Cancel', () => this.cancel(), 'small');
    this.element = h('div', { class: 'task', role: 'status', hidden: true }, this.#text, this.#bar, stop);
  }

  /** Ends the work that is shown. */
  cancel(): void {
    this.#abort?.abort();
  }

  /** Shows work until it ends; it is cancelled when other work begins here. */
  async run<T>(
    what: string,
    work: (watch: { signal: AbortSignal; onProgress: (progress: Progress) => void }) => Promise<T>,
  ): Promise<T> {
    this.#abort?.abort();
    const abort = new AbortController();
    this.#abort = abort;
    this.#text.textContent = what;
    this.#bar.removeAttribute('value');
    this.element.hidden = false;
    try {
      return await work({
        signal: abort.signal,
        onProgress: ({ part, done, total }) => {
          if (this.#abort === abort) {
            this.#text.textContent = `${what}: ${part}`;
            this.#bar.max = Math.max(total, 1);
            this.#bar.value = done;
          }
        },
      });
    } finally {
      if (this.#abort === abort) {
        this.element.hidden = true;
        this.#abort = undefined;
      }
    }
  }
}

/** Short news at the edge of the page; faults stay until they are closed. */
export class Notices {
  readonly element = h('div', { class: 'notices', 'aria-live': 'polite' });

  say(text: string): void {
    this.#show(text, 'said');
  }

  /** News that stays until it is closed, with what may be done about it. */
  stay(text: string, action?: { readonly label: string; readonly act: () => unknown }): void {
    const notice = this.#show(text, 'stays');
    if (action !== undefined) {
      notice.firstElementChild?.append(button(action.label, () => {
        notice.remove();
        action.act();
      }, 'primary small'));
    }
  }

  fault(error: unknown): void {
    if (error instanceof Error && 'code' in error && error.code === 'cancelled') {
      return;
    }
    this.#show(error instanceof Error ? error.message : String(error), 'fault');
  }

  #show(text: string, kind: string): HTMLElement {
    const close = h('button', { type: 'button', class: 'close', 'aria-label': 'Close', onclick: () => notice.remove() }, '×');
    const notice = h('div', { class: `notice ${kind}`, role: kind === 'fault' ? 'alert' : undefined }, h('div', { class: 'stack' }, h('p', {}, text)), close);
    this.element.replaceChildren(notice);
    if (kind === 'said') {
      setTimeout(() => notice.remove(), 6000);
    }
    return notice;
  }
}

/** Figures with their names, renewed in place. */
export class Readout {
  readonly element = h('dl', { class: 'readout' });
  readonly #values = new Map<string, HTMLElement>();

  /** Shows a value; without one, its row goes. */
  set(name: string, value: string | undefined): void {
    let shown = this.#values.get(name);
    if (shown === undefined) {
      shown = h('dd', {});
      this.#values.set(name, shown);
      this.element.append(h('div', {}, h('dt', {}, name), shown));
    }
    (shown.parentElement as HTMLElement).hidden = value === undefined;
    if (value !== undefined && shown.textContent !== value) {
      shown.textContent = value;
    }
  }
}

export type { Control };
