import type { Asset } from '@articula/core';
import { type BufferGeometry, MeshStandardMaterial } from 'three';

import type { FileMaterials } from './file-materials.js';
import { addMorphs, type MaterialRange, skinnedGeometry } from './geometry.js';
import { type FigureMaterial, makeMaterial } from './materials.js';
import { FileTextures } from './textures.js';

/** What is made once of a file and shared by all of its figures. */
export interface FigureShape {
  readonly geometry: BufferGeometry;
  readonly ranges: readonly MaterialRange[];
  /** Morph target of each influence. */
  readonly morphs: readonly number[];
  readonly bindings: number;
}

/** What a character tells of its picture, in whatever module it is. */
export type PicturedAsset = Pick<Asset, 'free' | 'image' | 'materials' | 'mesh' | 'morphNames' | 'warnings'>;

/** What is drawn of a character: its finest mesh, materials and textures. */
export class AssetLook {
  readonly core: PicturedAsset;
  /** What was left out or computed again, in words. */
  readonly warnings: readonly string[];
  /** The materials of the file, then the one of parts without. */
  readonly materials: FigureMaterial[];
  /** Names of the variants of the materials. */
  readonly variants: readonly string[];
  readonly #textures: FileTextures;
  /** What each variant shows in place of materials. */
  readonly #changes: readonly ReadonlyMap<number, number>[];
  #shape: FigureShape | undefined;

  private constructor(
    core: PicturedAsset,
    materials: FigureMaterial[],
    textures: FileTextures,
    variants: NonNullable<FileMaterials['variants']>,
    warnings: readonly string[],
  ) {
    this.core = core;
    this.materials = materials;
    this.#textures = textures;
    this.variants = variants.map(({ name }, i) => name ?? String(i));
    this.#changes = variants.map((variant) => new Map(variant.materials));
    this.warnings = warnings;
  }

  /** Takes over a character, and makes its materials. */
  static async of(core: PicturedAsset): Promise<AssetLook> {
    const warnings = [...core.warnings];
    const file = JSON.parse(core.materials()) as FileMaterials;
    const textures = new FileTextures(file, (index) => core.image(index));
    const mesh = core.mesh();
    const colored = Boolean(mesh.colors());
    mesh.free();
    const materials = await Promise.all(
      (file.materials ?? []).map((material) => makeMaterial(material, textures, colored, warnings)),
    );
    materials.push(new MeshStandardMaterial({ metalness: 1, roughness: 1, vertexColors: colored }));
    const variants = file.variants ?? [];
    for (const { name, mixed } of variants.filter(({ mixed }) => mixed.length > 0)) {
      warnings.push(`variant ${name ?? ''}: not all parts of the materials ${mixed.join(', ')} show it`);
    }
    return new AssetLook(core, materials, textures, variants, warnings);
  }

  /** Returns the material of a part; -1 has the one of parts without. */
  material(index: number): FigureMaterial {
    return this.materials.at(index) ?? (this.materials.at(-1) as FigureMaterial);
  }

  /** The material that a variant, -1 for none, shows in place of one. */
  materialOf(index: number, variant: number): number {
    return this.#changes[variant]?.get(index) ?? index;
  }

  /** The finest mesh, made when it is first asked for. */
  shape(): FigureShape {
    this.#shape ??= this.#makeShape();
    return this.#shape;
  }

  /** Releases the character, geometry, materials and textures. */
  dispose(): void {
    this.#shape?.geometry.dispose();
    this.#shape = undefined;
    for (const material of this.materials) {
      material.dispose();
    }
    this.#textures.dispose();
    this.core.free();
  }

  #makeShape(): FigureShape {
    const mesh = this.core.mesh();
    const { geometry, ranges } = skinnedGeometry(mesh);
    const morphs = addMorphs(geometry, mesh, this.core.morphNames);
    const { bindings } = mesh;
    mesh.free();
    return { geometry, ranges, morphs, bindings };
  }
}
