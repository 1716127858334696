import type { Articula, Asset } from '@articula/core';
import { type BufferGeometry, Box3, MeshStandardMaterial, Vector3 } from 'three';

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

/** A character that was opened: clips, meshes, materials and textures. Figures and crowds are made of it. */
export class ArticulaAsset {
  readonly articula: Articula;
  readonly core: Asset;
  readonly name: string;
  readonly joints: readonly string[];
  readonly clips: readonly string[];
  /** Duration of each clip in seconds. */
  readonly clipSecs: readonly number[];
  readonly expressions: readonly string[];
  readonly morphNames: readonly string[];
  /** The box around the rest pose. */
  readonly bounds: Box3;
  /** What was left out or computed again, in words. */
  readonly warnings: readonly string[];
  /** The materials of the file, then the one of parts without. May be changed before figures are made. */
  readonly materials: FigureMaterial[];
  readonly #textures: FileTextures;
  #shape: FigureShape | undefined;

  private constructor(
    articula: Articula,
    core: Asset,
    materials: FigureMaterial[],
    textures: FileTextures,
    warnings: readonly string[],
  ) {
    this.articula = articula;
    this.core = core;
    this.name = core.name;
    this.joints = core.joints;
    this.clips = core.clips;
    this.clipSecs = Array.from(core.clipSecs);
    this.expressions = core.expressions;
    this.morphNames = core.morphNames;
    const [x0 = 0, y0 = 0, z0 = 0, x1 = 0, y1 = 0, z1 = 0] = core.bounds;
    this.bounds = new Box3(new Vector3(x0, y0, z0), new Vector3(x1, y1, z1));
    this.warnings = warnings;
    this.materials = materials;
    this.#textures = textures;
  }

  /** Takes over a character that was opened, and makes its materials. */
  static async of(articula: Articula, core: Asset): Promise<ArticulaAsset> {
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
    return new ArticulaAsset(articula, core, materials, textures, warnings);
  }

  /** Returns the material of a part; -1 has the one of parts without. */
  material(index: number): FigureMaterial {
    return this.materials.at(index) ?? (this.materials.at(-1) as FigureMaterial);
  }

  /** Returns the index of a clip. */
  clip(name: string): number {
    return indexIn(this.clips, name, 'clip', this.name);
  }

  /** Returns the index of a joint. */
  joint(name: string): number {
    return indexIn(this.joints, name, 'joint', this.name);
  }

  /** The finest mesh, made when it is first asked for. */
  shape(): FigureShape {
    this.#shape ??= this.#makeShape();
    return this.#shape;
  }

  /** Releases the file, geometry, materials and textures. Dispose of figures and crowds of it first. */
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
    const morphs = addMorphs(geometry, mesh, this.morphNames);
    const { bindings } = mesh;
    mesh.free();
    return { geometry, ranges, morphs, bindings };
  }
}

/** Returns where `name` is in `names`; throws with what there is. */
export function indexIn(names: readonly string[], name: string, what: string, file: string): number {
  const index = names.indexOf(name);
  if (index < 0) {
    throw new RangeError(`${file} has no ${what} "${name}"; it has ${names.join(', ') || 'none'}`);
  }
  return index;
}
