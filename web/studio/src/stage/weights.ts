import { USUAL } from '../state.js';
import type { Studio } from '../studio.js';
import type { StageColumn } from './column.js';

/** Errors of a clip of a character by a weight. */
interface Found {
  readonly character: Studio['character'];
  readonly clip: number;
  readonly beta: number;
  readonly errors: Float32Array;
}

/** Errors of the clip that is played by the weight that the metric has. */
export class Weights {
  /** The weight of the errors that figures have; some have other errors than their file if it is not the usual one. */
  beta = USUAL.beta;
  readonly #studio: Studio;
  #isBusy = false;
  /** What was found last: columns that come later have it at once. */
  #found: Found | undefined;
  /** What was asked for while errors were found. */
  #next: (() => Promise<void>) | undefined;

  constructor(studio: Studio) {
    this.#studio = studio;
  }

  /**
   * Gives the columns that there are then the errors of their clip, and steers them by `then`; nothing where the file has
   * them already.
   */
  async apply(columns: () => readonly StageColumn[], then: () => void): Promise<void> {
    if (this.#isBusy) {
      this.#next = () => this.apply(columns, then);
      return;
    }
    const { state, character } = this.#studio;
    const { asset, bytes, name } = character;
    const clip = Math.max(asset.clips.indexOf(state.clip), 0);
    const { beta } = state;
    const isUsual = beta === USUAL.beta;
    if (state.metric !== 'thesis' || asset.clips.length === 0 || (isUsual && this.beta === USUAL.beta)) {
      return;
    }
    this.#isBusy = true;
    try {
      const found = this.#found;
      const isKnown = found?.character === character && found.clip === clip && found.beta === beta;
      const known = isKnown ? found.errors : undefined;
      const errors = isUsual ? undefined : (known ?? (await this.#studio.articula.tools.errorMatrix(bytes, name, { clip: asset.clips[clip], beta })));
      if (character === this.#studio.character) {
        this.#found = errors && { character, clip, beta, errors };
        columns().forEach((column) => column.weigh(clip, errors));
        this.beta = beta;
        then();
      }
    } catch (error) {
      this.#studio.notices.fault(error);
    } finally {
      this.#isBusy = false;
    }
    const next = this.#next;
    this.#next = undefined;
    await next?.();
  }
}
