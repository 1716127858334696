import type { ImpostorTable } from '@articula/core';
import { BufferGeometry, DataTexture, Float32BufferAttribute, LinearFilter, LinearMipmapLinearFilter, MathUtils, MeshBasicMaterial, SRGBColorSpace } from 'three';
import type { Material, Texture } from 'three';

import { DataRows } from './data-rows.js';
import { type Pixels, withMipmaps } from './impostor-pixels.js';

/** What shaders of impostors read. */
export interface ImpostorShape {
  /** Of each row of directions: least pitch of the eyes, pitch, lean, number of yaws; then the centre of each pose. */
  readonly places: Texture;
  readonly rows: number;
  /** Pictures of a pose. */
  readonly directions: number;
  readonly cell: ImpostorTable['cell'];
  /** Width and height of the atlas in pixels. */
  readonly atlasPx: readonly [number, number];
}

/** Pictures of a character for who is far away, as `articula flatten --profile impostor` and `tools.impostors` make them. */
export class ArticulaImpostors {
  readonly table: ImpostorTable;
  /** All pictures. */
  readonly texture: Texture;
  /**
   * What draws them: unlit, since their light is in them. Pictures without it need another material with `map` and
   * `alphaTest`, such as a `MeshLambertMaterial`. May be changed before crowds are made.
   */
  material: Material;
  /** What shaders read. */
  readonly shape: ImpostorShape;
  #geometry: BufferGeometry | undefined;

  private constructor(table: ImpostorTable, pixels: Pixels) {
    this.table = table;
    this.texture = textureOf(pixels);
    this.material = new MeshBasicMaterial({ map: this.texture, alphaTest: 0.5 });
    const { cell, rows } = table;
    const directions = rows.reduce((sum, { yaws }) => sum + yaws, 0);
    this.shape = { places: placesOf(table), rows: rows.length, directions, cell, atlasPx: [pixels.width, pixels.height] };
  }

  /** Loads a table and the picture beside it. */
  static async load(url: string): Promise<ArticulaImpostors> {
    const table = (await (await fetched(url)).json()) as ImpostorTable;
    const beside = new URL(table.picture, new URL(url, document.baseURI));
    return ArticulaImpostors.of(table, await (await fetched(beside.href)).blob());
  }

  /** Takes over a table and its picture, a PNG file. */
  static async of(table: ImpostorTable, picture: Blob | Uint8Array): Promise<ArticulaImpostors> {
    if (table.format !== 'articula-impostor' || table.version !== 1) {
      throw new TypeError('the table is not of impostors: articula-impostor, version 1');
    }
    const blob = picture instanceof Blob ? picture : new Blob([picture.slice()], { type: 'image/png' });
    return new ArticulaImpostors(table, await pixelsOf(blob));
  }

  /** A square whose corners shaders place. */
  geometry(): BufferGeometry {
    this.#geometry ??= squareGeometry();
    return this.#geometry;
  }

  /** Releases textures and material. Dispose of crowds that show them first. */
  dispose(): void {
    this.texture.dispose();
    this.material.dispose();
    this.shape.places.dispose();
    this.#geometry?.dispose();
  }
}

async function fetched(url: string): Promise<Response> {
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${url}: ${response.status} ${response.statusText}`);
  }
  return response;
}

async function pixelsOf(picture: Blob): Promise<Pixels> {
  const bitmap = await createImageBitmap(picture, { premultiplyAlpha: 'none', colorSpaceConversion: 'none' });
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  if (context === null) {
    throw new Error('no canvas for the pictures of impostors');
  }
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return { width, height, data: new Uint8Array(context.getImageData(0, 0, width, height).data.buffer) };
}

function textureOf(pixels: Pixels): DataTexture {
  const texture = new DataTexture(pixels.data, pixels.width, pixels.height);
  texture.mipmaps = withMipmaps(pixels);
  texture.colorSpace = SRGBColorSpace;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = false;
  texture.needsUpdate = true;
  return texture;
}

function placesOf({ rows, clips }: ImpostorTable): Texture {
  const { degToRad } = MathUtils;
  const directions = rows.flatMap((row) => [degToRad(row.from_deg), degToRad(row.pitch_deg), row.lean, row.yaws]);
  const centres = clips.flatMap(({ centres_m }) => centres_m);
  const places = new DataRows(4);
  places.write(Float32Array.from(directions));
  const texels = new Float32Array((centres.length / 3) * 4);
  centres.forEach((metres, i) => {
    texels[Math.floor(i / 3) * 4 + (i % 3)] = metres;
  });
  places.write(texels, directions.length);
  return places.texture;
}

function squareGeometry(): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0], 3));
  geometry.setAttribute('normal', new Float32BufferAttribute([0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1], 3));
  geometry.setAttribute('uv', new Float32BufferAttribute([0, 0, 1, 0, 0, 1, 1, 1], 2));
  geometry.setIndex([0, 1, 2, 2, 1, 3]);
  return geometry;
}
