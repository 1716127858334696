import {
  ClampToEdgeWrapping,
  LinearFilter,
  LinearMipmapLinearFilter,
  LinearMipmapNearestFilter,
  type MagnificationTextureFilter,
  type MinificationTextureFilter,
  MirroredRepeatWrapping,
  NearestFilter,
  NearestMipmapLinearFilter,
  NearestMipmapNearestFilter,
  NoColorSpace,
  RepeatWrapping,
  SRGBColorSpace,
  Texture,
  type Wrapping,
} from 'three';

import type { FileMaterials, FileTextureUse } from './file-materials.js';

const MAG: Readonly<Record<number, MagnificationTextureFilter>> = { 9728: NearestFilter, 9729: LinearFilter };

const MIN: Readonly<Record<number, MinificationTextureFilter>> = {
  9728: NearestFilter,
  9729: LinearFilter,
  9984: NearestMipmapNearestFilter,
  9985: LinearMipmapNearestFilter,
  9986: NearestMipmapLinearFilter,
  9987: LinearMipmapLinearFilter,
};

const WRAP: Readonly<Record<number, Wrapping>> = {
  33071: ClampToEdgeWrapping,
  33648: MirroredRepeatWrapping,
  10497: RepeatWrapping,
};

/** What the numbers of a texture mean. */
export type TextureMeaning = 'colour' | 'data';

/** The pictures of a file, decoded once each, and textures of them, made once for each use. */
export class FileTextures {
  readonly #file: FileMaterials;
  readonly #image: (index: number) => Uint8Array;
  readonly #pictures = new Map<number, Promise<ImageBitmap>>();
  readonly #textures = new Map<string, Promise<Texture>>();

  constructor(file: FileMaterials, image: (index: number) => Uint8Array) {
    this.#file = file;
    this.#image = image;
  }

  /** Returns the texture of a use. */
  get(use: FileTextureUse, meaning: TextureMeaning): Promise<Texture> {
    const key = `${use.index} ${meaning}`;
    let texture = this.#textures.get(key);
    if (texture === undefined) {
      texture = this.#make(use, meaning);
      this.#textures.set(key, texture);
    }
    return texture;
  }

  async #make(use: FileTextureUse, meaning: TextureMeaning): Promise<Texture> {
    const source = this.#file.textures?.[use.index];
    if (source === undefined || source.image === undefined || source.image === null) {
      throw new Error(`texture ${use.index} has no picture that can be read`);
    }
    const texture = new Texture(await this.#picture(source.image));
    const sampler = source.sampler ?? {};
    texture.flipY = false;
    texture.colorSpace = meaning === 'colour' ? SRGBColorSpace : NoColorSpace;
    texture.magFilter = MAG[sampler.magFilter ?? 9729] ?? LinearFilter;
    texture.minFilter = MIN[sampler.minFilter ?? 9987] ?? LinearMipmapLinearFilter;
    texture.wrapS = WRAP[sampler.wrapS ?? 10497] ?? RepeatWrapping;
    texture.wrapT = WRAP[sampler.wrapT ?? 10497] ?? RepeatWrapping;
    texture.generateMipmaps = texture.minFilter !== NearestFilter && texture.minFilter !== LinearFilter;
    texture.needsUpdate = true;
    return texture;
  }

  #picture(index: number): Promise<ImageBitmap> {
    let picture = this.#pictures.get(index);
    if (picture === undefined) {
      const type = this.#file.images?.[index]?.mimeType ?? 'image/png';
      const blob = new Blob([this.#image(index).slice()], { type });
      picture = createImageBitmap(blob, { premultiplyAlpha: 'none', colorSpaceConversion: 'none' });
      this.#pictures.set(index, picture);
    }
    return picture;
  }

  /** Releases all pictures and textures. */
  dispose(): void {
    const ignore = (): void => undefined;
    for (const texture of this.#textures.values()) {
      texture.then((made) => made.dispose(), ignore);
    }
    for (const picture of this.#pictures.values()) {
      picture.then((decoded) => decoded.close(), ignore);
    }
    this.#textures.clear();
    this.#pictures.clear();
  }
}
