import type { Crowd } from '../wasm/play.js';
import { MATRIX_FLOATS } from './figure.js';
import type { ImpostorTable } from './impostors.js';

/** What the instances of a draw group are: rows of `draws`, `records` or `stepped`, or pictures. */
export type DrawKind = 'palette' | 'record' | 'step' | 'impostor';

const KINDS: readonly DrawKind[] = ['palette', 'record', 'step', 'impostor'];
const GROUP_NUMBERS = 6;

/** Instances that are drawn by one call: of one kind, with the mesh of one level. */
export interface DrawGroup {
  readonly kind: DrawKind;
  readonly level: number;
  /** The first row, in the list of the kind. */
  readonly first: number;
  readonly count: number;
  /** Instance `i` of the group has set `firstMorphSet + i` of `morphWeights` if `i < morphSets`. */
  readonly firstMorphSet: number;
  readonly morphSets: number;
}

/** An event at a time of a clip, such as a footstep. */
export interface ClipEvent {
  /** Seconds within the clip. */
  readonly secs: number;
  /** A number by which it is told. */
  readonly id: number;
}

/** Events by the names of their clips. */
export type ClipEvents = Readonly<Record<string, readonly ClipEvent[]>>;

/** How the instances of a crowd are made. */
export interface CrowdOptions {
  /** Names of the clips that are played; all of the asset if left out. */
  readonly clips?: readonly string[];
  /** Events of these clips. */
  readonly events?: ClipEvents;
  /** The table of pictures that show who is far enough away, where poses can be taken from a cache. */
  readonly impostors?: ImpostorTable;
  /** Meshes of less detail, with the finest; 1 is the finest alone. As many as the asset has if not told; a file without them is prepared with `tools.prepare` first. */
  readonly meshLevels?: number;
  /** Whether poses can be taken from a cache. */
  readonly poseCache?: boolean;
  /** What becomes of the motion of the root. */
  readonly rootMotion?: 'in-place' | 'as-authored' | 'extracted';
}

/**
 * The arrays of a crowd after its last frame, in the layouts of
 * `docs/formats/crowd-buffers.md`. They are valid until the next call of any method of the module.
 */
export class CrowdArrays {
  readonly #memory: WebAssembly.Memory;
  readonly #crowd: Crowd;
  readonly #morphs: number;

  constructor(memory: WebAssembly.Memory, crowd: Crowd, morphTargets: number) {
    this.#memory = memory;
    this.#crowd = crowd;
    this.#morphs = morphTargets;
  }

  /** What to draw. */
  groups(): DrawGroup[] {
    const count = this.#crowd.groups;
    const numbers = this.#integers(this.#crowd.groupsAt(), count * GROUP_NUMBERS);
    return Array.from({ length: count }, (_, i) => {
      const [kind = 0, level = 0, first = 0, size = 0, firstMorphSet = 0, morphSets = 0] = numbers.subarray(
        i * GROUP_NUMBERS,
        (i + 1) * GROUP_NUMBERS,
      );
      return { kind: KINDS[kind] ?? 'palette', level, first, count: size, firstMorphSet, morphSets };
    });
  }

  /** Matrices of the palettes of this frame. */
  get palettes(): Float32Array {
    return this.#floats(this.#crowd.palettesAt(), this.#crowd.paletteMatrices * MATRIX_FLOATS);
  }

  /** Two numbers a draw: character, first matrix in `palettes`. */
  get draws(): Uint32Array {
    return this.#integers(this.#crowd.drawsAt(), this.#crowd.draws * 2);
  }

  /** Four numbers a record: first matrix before and after in `cached`, the bits of the blend (f32), character. */
  get records(): Uint32Array {
    return this.#integers(this.#crowd.recordsAt(), this.#crowd.records * 4);
  }

  /** Two numbers a draw: character, first matrix in `cached`. */
  get stepped(): Uint32Array {
    return this.#integers(this.#crowd.steppedAt(), this.#crowd.stepped * 2);
  }

  /** Two numbers a draw: character, pose among those of all clips of the table. */
  get impostors(): Uint32Array {
    return this.#integers(this.#crowd.impostorsAt(), this.#crowd.impostors * 2);
  }

  /** Matrices of cached palettes, which never change. */
  get cached(): Float32Array {
    return this.#floats(this.#crowd.cachedAt(), this.#crowd.cachedMatrices * MATRIX_FLOATS);
  }

  /** World transforms, one matrix a character. */
  get transforms(): Float32Array {
    return this.#floats(this.#crowd.transformsAt(), this.#crowd.count * MATRIX_FLOATS);
  }

  /** Sets of morph target weights. */
  get morphWeights(): Float32Array {
    return this.#floats(this.#crowd.morphWeightsAt(), this.#crowd.morphSets * this.#morphs);
  }

  #floats(at: number, length: number): Float32Array {
    return new Float32Array(this.#memory.buffer, length === 0 ? 0 : at, length);
  }

  #integers(at: number, length: number): Uint32Array {
    return new Uint32Array(this.#memory.buffer, length === 0 ? 0 : at, length);
  }
}
