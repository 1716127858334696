import { DataTexture, FloatType, RedFormat, RGBAFormat } from 'three';

/** Something that has a texture: a uniform of a shader or a node of one. */
export interface TextureHolder {
  value: unknown;
}

/** Numbers that shaders read, as a texture of floats of any height. */
export class DataRows {
  /** Texels of a row: 512 matrices of three. Shaders have the same number. */
  static readonly WIDTH = 1536;
  readonly #channels: 1 | 4;
  readonly #holders: TextureHolder[] = [];
  /** Textures by height, powers of two: a texture is sent whole, so one that fits is shown. */
  readonly #textures = new Map<number, DataTexture>();
  #texture: DataTexture;

  constructor(channels: 1 | 4) {
    this.#channels = channels;
    this.#texture = this.#ofHeight(1);
  }

  get texture(): DataTexture {
    return this.#texture;
  }

  /** Keeps `value` of a holder at the texture. */
  hold<T extends TextureHolder>(holder: T): T {
    holder.value = this.#texture;
    this.#holders.push(holder);
    return holder;
  }

  /** Takes over numbers in place of all others. */
  replace(numbers: Float32Array): void {
    if (numbers.length > 0) {
      this.#show(this.#ofHeight(this.#heightFor(numbers.length)));
      this.#set(numbers, 0);
    }
  }

  /** Takes over numbers from `at` on; the others stay. */
  write(numbers: Float32Array, at = 0): void {
    if (numbers.length === 0) {
      return;
    }
    const height = this.#heightFor(at + numbers.length);
    const { data, height: had } = this.#texture.image;
    if (height > had) {
      const grown = this.#ofHeight(height);
      (grown.image.data as Float32Array).set(data as Float32Array);
      this.#show(grown);
      this.#textures.get(had)?.dispose();
      this.#textures.delete(had);
    }
    this.#set(numbers, at);
  }

  /** Has the texture sent again. */
  invalidate(): void {
    this.#texture.needsUpdate = true;
  }

  dispose(): void {
    for (const texture of this.#textures.values()) {
      texture.dispose();
    }
  }

  /** The least power of two whose rows hold so many numbers. */
  #heightFor(numbers: number): number {
    return 2 ** Math.ceil(Math.log2(Math.ceil(numbers / (DataRows.WIDTH * this.#channels))));
  }

  #set(numbers: Float32Array, at: number): void {
    (this.#texture.image.data as Float32Array).set(numbers, at);
    this.#texture.needsUpdate = true;
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
    const data = new Float32Array(DataRows.WIDTH * height * this.#channels);
    const format = this.#channels === 1 ? RedFormat : RGBAFormat;
    const texture = new DataTexture(data, DataRows.WIDTH, height, format, FloatType);
    texture.needsUpdate = true;
    this.#textures.set(height, texture);
    return texture;
  }
}
