import { Color, type Material } from 'three';

import type { DataRows } from './data-rows.js';
import type { ImpostorShape } from './impostors.js';

/** Morph targets that move a mesh, for shaders. */
export interface CrowdMorphs {
  /** The index of each target among all of the asset; then deltas of position and normal of each vertex, by target. */
  readonly deltas: DataRows;
  readonly targets: number;
  readonly vertices: number;
}

/** What shaders read of each character. */
export interface CrowdPlaces {
  readonly transforms: DataRows;
  /** Colour of each character, if one was ever set. */
  readonly colors: DataRows | undefined;
}

/** What shaders of a crowd read, and how. */
export interface CrowdShape extends CrowdPlaces {
  /** Whether instances are blend records (uvec4) or have a palette (uvec2). */
  readonly blended: boolean;
  /** Whether vertices have the colour of the material, which differs by part. */
  readonly coloredByVertices: boolean;
  /** Matrices of palettes. */
  readonly palettes: DataRows;
  /** Runs of four influences of a vertex. */
  readonly fours: number;
  readonly morphs: CrowdMorphs | undefined;
  /** Weights of morph targets: the defaults, then the sets of the frame. */
  readonly weights: DataRows;
  /** Morph targets of the asset. */
  readonly morphTargets: number;
}

/** The materials that draw a part of a crowd. */
export interface CrowdMaterials {
  readonly material: Material;
  /** For shadows, where the renderer needs them. */
  readonly depth?: Material;
  readonly distance?: Material;
}

/** Makes materials whose vertices are posed on the GPU. */
export interface CrowdShading {
  materials(source: Material, shape: CrowdShape): CrowdMaterials;
  /** Materials of squares that show impostors. */
  impostors(source: Material, shape: ImpostorShape, places: CrowdPlaces): CrowdMaterials;
}

/** Makes a material, a copy, show the colours of vertices in place of its own. */
export function colorByVertices(material: Material & { color?: Color }): void {
  material.color = new Color(1, 1, 1);
  material.vertexColors = true;
}

/** Names of vertex attributes. */
export const DRAW = 'articulaDraw';
export const MORPH_SET = 'articulaSet';
export const entriesOf = (four: number): string => `articulaEntries${four}`;
export const weightsOf = (four: number): string => `articulaWeights${four}`;
