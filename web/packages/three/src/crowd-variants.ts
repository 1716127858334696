import { indexIn } from './asset.js';

/** Words of a draw, and which of them has its character. */
export interface DrawWords {
  readonly count: number;
  readonly character: number;
}

/** Which characters show a variant of the file's materials. */
export class CrowdVariants {
  readonly #names: readonly string[];
  readonly #file: string;
  /** Variant of each character, from 1; 0 has none. */
  readonly #of: Uint16Array;
  #isUsed = false;

  constructor(names: readonly string[], file: string, count: number) {
    this.#names = names;
    this.#file = file;
    this.#of = new Uint16Array(count);
  }

  set(character: number, name: string | undefined): void {
    if (!(Number.isInteger(character) && character >= 0 && character < this.#of.length)) {
      throw new RangeError(`there is no character ${character}; there are ${this.#of.length}`);
    }
    this.#of[character] = name === undefined ? 0 : indexIn(this.#names, name, 'variant', this.#file) + 1;
    this.#isUsed ||= name !== undefined;
  }

  /**
   * Sorts draws by variant: where the draws of each are among those given, the variants from 0 on, -1 for none;
   * undefined if no character ever had one.
   */
  split(list: Uint32Array, words: DrawWords): Map<number, number[]> | undefined {
    if (!this.#isUsed) {
      return undefined;
    }
    const found = new Map<number, number[]>();
    for (let i = 0; i * words.count < list.length; i += 1) {
      const character = list[i * words.count + words.character] as number;
      const variant = (this.#of[character] as number) - 1;
      const draws = found.get(variant);
      if (draws === undefined) {
        found.set(variant, [i]);
      } else {
        draws.push(i);
      }
    }
    return found;
  }
}
