import { DataTexture, FloatType, RedFormat, RGBAFormat } from 'three';

/** Something that has a texture: a uniform of a shader or a node of one. */
export interface TextureHolder {
  value: unknown;
}

/** Numbers that shaders read: a texture of floats that grows. */
export class DataRows {
  /** Texels of a row: 512 matrices of three. Shaders have the same number. */
  static readonly WIDTH = 1536;
  readonly #channels: 1 | 4;
  readonly #holders: TextureHolder[] = [];
  #texture: DataTexture;

  constructor(channels: 1 | 4) {
    this.#channels = channels;
    this.#texture = this.#make(1);
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

  /** Takes over numbers, from `at` on. */
  write(numbers: Float32Array, at = 0): void {
    if (numbers.length === 0) {
      return;
    }
    const rows = Math.ceil((at + numbers.length) / (DataRows.WIDTH * this.#channels));
    const { height } = this.#texture.image;
    if (rows > height) {
      this.#grow(Math.max(rows, Math.ceil(height * 1.5)));
    }
    (this.#texture.image.data as Float32Array).set(numbers, at);
    this.#texture.needsUpdate = true;
  }

  /** Has the texture sent again. */
  invalidate(): void {
    this.#texture.needsUpdate = true;
  }

  dispose(): void {
    this.#texture.dispose();
  }

  #grow(height: number): void {
    const old = this.#texture;
    this.#texture = this.#make(height);
    (this.#texture.image.data as Float32Array).set(old.image.data as Float32Array);
    old.dispose();
    for (const holder of this.#holders) {
      holder.value = this.#texture;
    }
  }

  #make(height: number): DataTexture {
    const data = new Float32Array(DataRows.WIDTH * height * this.#channels);
    const format = this.#channels === 1 ? RedFormat : RGBAFormat;
    const texture = new DataTexture(data, DataRows.WIDTH, height, format, FloatType);
    texture.needsUpdate = true;
    return texture;
  }
}
