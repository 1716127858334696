import { h } from '../ui/dom.js';
import { choice } from '../ui/controls.js';
import type { Studio } from '../studio.js';

const PLAY = 'M4 2.5v11l9-5.5z';
const PAUSE = 'M4 2.5h3v11H4zM9 2.5h3v11H9z';

/** The clock of the page: play, pause, loop, speed, and a time to drag. */
export class Timeline {
  readonly element: HTMLElement;
  /** Seconds of the page's clock, by which transitions go. */
  now = 0;
  /** Seconds of the clip. */
  secs: number;
  readonly #studio: Studio;
  readonly #time = h('input', { type: 'range', min: 0, max: 1, step: 'any', 'aria-label': 'Time' });
  readonly #shown = h('output', { class: 'value' });
  readonly #play: HTMLButtonElement;
  readonly #icon = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  #length = 1;

  /** `more` is shown beside its buttons. */
  constructor(studio: Studio, more: HTMLElement) {
    this.#studio = studio;
    this.secs = studio.state.at;
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    svg.setAttribute('viewBox', '0 0 16 16');
    svg.setAttribute('aria-hidden', 'true');
    svg.append(this.#icon);
    this.#play = h('button', { type: 'button', class: 'icon-button', onclick: () => this.toggle() }, svg);
    const loop = h('button', { type: 'button', class: 'button small', 'aria-pressed': studio.state.loop, onclick: () => {
      studio.set({ loop: !studio.state.loop });
      loop.setAttribute('aria-pressed', String(studio.state.loop));
    } }, 'Loop');
    const speed = choice('Speed', ['0.1', '0.25', '0.5', '1', '2'].map((s) => [s, `${s}×`] as const), String(studio.state.speed), (s) => studio.set({ speed: Number(s) }));
    this.#time.addEventListener('input', () => {
      this.pause();
      this.seek(this.#time.valueAsNumber);
    });
    this.element = h('div', { class: 'timeline' }, this.#play, this.#time, this.#shown, loop, more, speed.element);
    this.#paint();
  }

  /** Takes over the length of another clip. */
  setLength(secs: number): void {
    this.#length = Math.max(secs, 1e-3);
    this.#time.max = String(this.#length);
    this.secs = this.secs < this.#length ? this.secs : 0;
    this.#paint();
  }

  toggle(): void {
    if (this.#studio.state.playing) {
      this.pause();
    } else {
      if (!this.#studio.state.loop && this.secs >= this.#end) {
        this.secs = 0;
      }
      this.#studio.set({ playing: true, at: 0 });
    }
    this.#paint();
  }

  pause(): void {
    this.#studio.set({ playing: false, at: Number(this.secs.toFixed(4)) });
    this.#paint();
  }

  /** Plays from a time of a clip that goes on in a loop. */
  restart(secs: number): void {
    this.secs = secs % this.#length;
    this.#studio.set({ playing: true, at: 0 });
    this.#paint();
  }

  /** Shows a time. */
  seek(secs: number): void {
    this.secs = Math.min(Math.max(secs, 0), this.#end);
    if (!this.#studio.state.playing) {
      this.#studio.set({ at: Number(this.secs.toFixed(4)) });
    }
    this.#paint();
  }

  /** Goes on by seconds of the page. */
  advance(dtSecs: number): void {
    this.now += dtSecs;
    const { playing, loop, speed } = this.#studio.state;
    if (!playing) {
      return;
    }
    const next = this.secs + dtSecs * speed;
    this.secs = loop ? next % this.#length : Math.min(next, this.#end);
    if (!loop && next >= this.#length) {
      this.pause();
    }
    this.#paint();
  }

  /** The last moment; the length itself is the start again. */
  get #end(): number {
    return this.#length * 0.9999;
  }

  #paint(): void {
    const { playing } = this.#studio.state;
    this.#icon.setAttribute('d', playing ? PAUSE : PLAY);
    this.#play.setAttribute('aria-label', playing ? 'Pause' : 'Play');
    this.#time.value = String(this.secs);
    const shown = `${this.secs.toFixed(2)} / ${this.#length.toFixed(2)} s`;
    this.#shown.textContent = shown;
    this.#time.setAttribute('aria-valuetext', `${this.secs.toFixed(2)} seconds`);
  }
}
