/** A texture as a glTF material names it. */
export interface FileTextureUse {
  readonly index: number;
  readonly scale?: number;
  readonly strength?: number;
}

/** The parts of a glTF material that are shown. */
export interface FileMaterial {
  readonly name?: string;
  readonly alphaMode?: 'OPAQUE' | 'MASK' | 'BLEND';
  readonly alphaCutoff?: number;
  readonly doubleSided?: boolean;
  readonly emissiveFactor?: readonly [number, number, number];
  readonly emissiveTexture?: FileTextureUse;
  readonly normalTexture?: FileTextureUse;
  readonly occlusionTexture?: FileTextureUse;
  readonly pbrMetallicRoughness?: {
    readonly baseColorFactor?: readonly [number, number, number, number];
    readonly baseColorTexture?: FileTextureUse;
    readonly metallicFactor?: number;
    readonly roughnessFactor?: number;
    readonly metallicRoughnessTexture?: FileTextureUse;
  };
  readonly extensions?: {
    readonly KHR_materials_unlit?: object;
    readonly KHR_materials_emissive_strength?: { readonly emissiveStrength?: number };
  };
}

/**
 * What a file says of its materials, as `Asset.materials` returns it. The texture coordinates of the mesh are those of
 * the base colour, with their transform, so textures have none.
 */
export interface FileMaterials {
  readonly materials?: readonly FileMaterial[];
  readonly textures?: readonly {
    readonly image?: number | null;
    readonly sampler?: {
      readonly magFilter?: number;
      readonly minFilter?: number;
      readonly wrapS?: number;
      readonly wrapT?: number;
    } | null;
  }[];
  /** Variants: pairs of a usual material and the one in its place, -1 for none; and usual ones of which not all parts show it. */
  readonly variants?: readonly {
    readonly name?: string;
    readonly materials: readonly (readonly [number, number])[];
    readonly mixed: readonly number[];
  }[];
  readonly images?: readonly { readonly mimeType?: string | null }[];
}
