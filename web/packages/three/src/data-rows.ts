import { type BufferAttribute, DataTexture, FloatType, RedFormat, RGBAFormat } from 'three';

/** Something that has a texture or a buffer: a uniform of a shader or a node of one. */
export interface Holder {
  value: unknown;
}

/** Makes a buffer of numbers, of as many for each element. */
export type MakeBuffer = (numbers: Float32Array, channels: number) => BufferAttribute;

/** Numbers that shaders read, as a texture of floats of any height or as a buffer. */
export class DataRows {
  /** Texels of a row: 512 matrices of three. Shaders have the same number. */
  static readonly WIDTH = 1536;
  /** Numbers of a texel. */
  readonly channels: 1 | 4;
  readonly #holders: Holder[] = [];
  readonly #bufferHolders: Holder[] = [];
  /** Textures by height, powers of two: a texture is sent whole, so the least that fits is shown. They share the numbers. */
  readonly #textures = new Map<number, DataTexture>();
  #numbers: Float32Array;
  /** Where the numbers are that are shown in place of the own ones. */
  #shared: { readonly memory: WebAssembly.Memory; readonly offset: number; readonly length: number } | undefined;
  #texture: DataTexture;
  /** A buffer of the same numbers, of which a part can be sent. */
  #buffer: BufferAttribute | undefined;
  #makeBuffer: MakeBuffer | undefined;

  constructor(channels: 1 | 4) {
    this.channels = channels;
    this.#numbers = new Float32Array(DataRows.WIDTH * channels);
    this.#texture = this.#ofHeight(1);
  }

  get texture(): DataTexture {
    return this.#texture;
  }

  /** Keeps `value` of a holder at the texture. */
  hold<T extends Holder>(holder: T): T {
    holder.value = this.#texture;
    this.#holders.push(holder);
    return holder;
  }

  /** Returns the buffer, which `make` makes if there is none yet. */
  buffer(make: MakeBuffer): BufferAttribute {
    if (this.#buffer === undefined) {
      this.#copyShared();
    }
    this.#makeBuffer ??= make;
    this.#buffer ??= make(this.#numbers, this.channels);
    return this.#buffer;
  }

  /** Keeps `value` of a holder at the buffer. */
  holdBuffer(holder: Holder): void {
    this.#bufferHolders.push(holder);
  }

  /**
   * Shows numbers of a memory in place of all others. Textures are sent from there, without a copy: until then and until
   * the next call they must stay.
   */
  share(memory: WebAssembly.Memory, numbers: Float32Array): void {
    if (numbers.length === 0) {
      return;
    }
    const height = this.#rowsFor(numbers.length);
    this.#shared = { memory, offset: numbers.byteOffset, length: numbers.length };
    if (this.#buffer !== undefined) {
      this.#grow(height);
      this.#buffer.clearUpdateRanges();
      this.#set(numbers, 0);
    }
    this.#show(this.#ofHeight(height));
    this.#texture.needsUpdate = true;
  }

  /** Takes over numbers from `at` on; the others stay. */
  write(numbers: Float32Array, at = 0): void {
    if (numbers.length === 0) {
      return;
    }
    const height = this.#rowsFor(at + numbers.length);
    this.#grow(height);
    if (height > this.#texture.image.height) {
      this.#show(this.#ofHeight(height));
    }
    this.#set(numbers, at);
  }

  /** Has everything sent again. */
  invalidate(): void {
    this.#texture.needsUpdate = true;
    if (this.#buffer !== undefined) {
      this.#buffer.clearUpdateRanges();
      this.#buffer.needsUpdate = true;
    }
  }

  dispose(): void {
    this.#release();
  }

  /** The least power of two whose rows hold so many numbers. */
  #rowsFor(numbers: number): number {
    return 2 ** Math.ceil(Math.log2(Math.ceil(numbers / (DataRows.WIDTH * this.channels))));
  }

  /** Makes room for rows. */
  #grow(height: number): void {
    const length = DataRows.WIDTH * height * this.channels;
    if (length <= this.#numbers.length) {
      return;
    }
    const grown = new Float32Array(length);
    grown.set(this.#numbers);
    this.#release();
    this.#numbers = grown;
    this.#show(this.#ofHeight(height));
    if (this.#makeBuffer !== undefined) {
      this.#buffer = this.#makeBuffer(grown, this.channels);
      for (const holder of this.#bufferHolders) {
        holder.value = this.#buffer;
      }
    }
  }

  #release(): void {
    for (const texture of this.#textures.values()) {
      texture.dispose();
    }
    this.#textures.clear();
    this.#buffer?.dispose();
    this.#buffer = undefined;
  }

  #set(numbers: Float32Array, at: number): void {
    this.#numbers.set(numbers, at);
    this.#texture.needsUpdate = true;
    if (this.#buffer !== undefined) {
      addRange(this.#buffer, at, at + numbers.length);
    }
  }

  /** The numbers that are shown, as many as a texture has: those beyond the last are any. */
  #numbersOf(length: number): Float32Array {
    const shared = this.#shared;
    if (shared !== undefined && shared.offset + 4 * length <= shared.memory.buffer.byteLength) {
      return new Float32Array(shared.memory.buffer, shared.offset, length);
    }
    this.#copyShared();
    return this.#numbers.subarray(0, length);
  }

  /** Copies the numbers that are shown to the own ones. */
  #copyShared(): void {
    const shared = this.#shared;
    if (shared === undefined) {
      return;
    }
    const { memory, offset, length } = shared;
    if (length > this.#numbers.length) {
      this.#numbers = new Float32Array(DataRows.WIDTH * this.channels * this.#rowsFor(length));
    }
    this.#numbers.set(new Float32Array(memory.buffer, offset, length));
  }

  #show(texture: DataTexture): void {
    this.#texture = texture;
    for (const holder of this.#holders) {
      holder.value = texture;
    }
  }

  #ofHeight(height: number): DataTexture {
    const made = this.#textures.get(height);
    if (made !== undefined) {
      return made;
    }
    const format = this.channels === 1 ? RedFormat : RGBAFormat;
    const texture = new DataTexture(null, DataRows.WIDTH, height, format, FloatType);
    const length = DataRows.WIDTH * height * this.channels;
    // Found when it is sent: the memory may have grown since, and its old views are then empty.
    Object.defineProperty(texture.image, 'data', { get: () => this.#numbersOf(length) });
    texture.needsUpdate = true;
    this.#textures.set(height, texture);
    return texture;
  }
}

/** Has numbers sent, with those between them and what was not sent yet, so that ranges stay few where nobody draws. */
function addRange(buffer: BufferAttribute, from: number, to: number): void {
  const [had] = buffer.updateRanges;
  const first = Math.min(from, had?.start ?? from);
  const last = Math.max(to, had === undefined ? to : had.start + had.count);
  buffer.clearUpdateRanges();
  buffer.addUpdateRange(first, last - first);
  buffer.needsUpdate = true;
}
