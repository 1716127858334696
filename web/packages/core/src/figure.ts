import type { Asset, Figure } from '../wasm/play.js';

/** Floats of a matrix: three rows of four, the fourth row is 0 0 0 1. */
export const MATRIX_FLOATS = 12;

/** What has the arrays of a figure, as byte offsets. */
export type FigureOffsets = Pick<Figure, 'paletteAt' | 'jointsAt' | 'morphsAt'>;

/** What tells how long the arrays of a figure are. */
export type FigureLengths = Pick<Asset, 'joints' | 'morphDefaults'>;

/** The arrays of a figure after its last frame. They are valid until the next call of any method of the module. */
export class FigureArrays {
  readonly #memory: WebAssembly.Memory;
  readonly #figure: FigureOffsets;
  readonly #joints: number;
  readonly #bindings: number;
  readonly #morphs: number;

  constructor(memory: WebAssembly.Memory, asset: FigureLengths, figure: FigureOffsets, bindings: number) {
    this.#memory = memory;
    this.#figure = figure;
    this.#joints = asset.joints.length;
    this.#bindings = bindings;
    this.#morphs = asset.morphDefaults.length;
  }

  /** Skinning matrices, one for each binding of the mesh: rest position to model space. */
  get palette(): Float32Array {
    return this.#floats(this.#figure.paletteAt(), this.#bindings * MATRIX_FLOATS);
  }

  /** Model-from-joint matrices. */
  get joints(): Float32Array {
    return this.#floats(this.#figure.jointsAt(), this.#joints * MATRIX_FLOATS);
  }

  /** Weights of the morph targets. */
  get morphs(): Float32Array {
    return this.#floats(this.#figure.morphsAt(), this.#morphs);
  }

  #floats(at: number, length: number): Float32Array {
    return new Float32Array(this.#memory.buffer, length === 0 ? 0 : at, length);
  }
}
