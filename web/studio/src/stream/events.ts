import { h } from '../ui/dom.js';

/** Events that are kept. */
const MOST = 60;

/** What has happened, with its time, the newest first. */
export class EventLog {
  readonly element = h('ol', { class: 'events', tabindex: 0, 'aria-label': 'Events' });
  #start = performance.now();

  /** Begins anew: times count from now. */
  begin(): void {
    this.#start = performance.now();
    this.element.replaceChildren();
  }

  say(text: string): void {
    const secs = ((performance.now() - this.#start) / 1000).toFixed(2);
    this.element.prepend(h('li', {}, h('time', {}, `${secs} s`), ` ${text}`));
    while (this.element.childElementCount > MOST) {
      this.element.lastElementChild?.remove();
    }
  }
}
