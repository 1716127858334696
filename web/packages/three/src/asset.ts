import type { Articula, Asset } from '@articula/core';
import { Box3, Vector3 } from 'three';

import { AssetLook, type FigureShape } from './asset-look.js';
import type { FigureMaterial } from './materials.js';

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
  /** Names of the variants of the materials (`KHR_materials_variants`). */
  readonly variants: readonly string[];
  readonly #look: AssetLook;

  private constructor(articula: Articula, core: Asset, look: AssetLook) {
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
    this.warnings = look.warnings;
    this.materials = look.materials;
    this.variants = look.variants;
    this.#look = look;
  }

  /** Takes over a character that was opened, and makes its materials. */
  static async of(articula: Articula, core: Asset): Promise<ArticulaAsset> {
    return new ArticulaAsset(articula, core, await AssetLook.of(core));
  }

  /** Returns the material of a part; -1 has the one of parts without. */
  material(index: number): FigureMaterial {
    return this.#look.material(index);
  }

  /** Returns the index of the material that a variant, -1 for none, shows in place of one. */
  materialOf(index: number, variant: number): number {
    return this.#look.materialOf(index, variant);
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
    return this.#look.shape();
  }

  /** Releases the file, geometry, materials and textures. Dispose of figures and crowds of it first. */
  dispose(): void {
    this.#look.dispose();
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
