import { Color, DoubleSide, LinearSRGBColorSpace, MeshBasicMaterial, MeshStandardMaterial } from 'three';
import type { Texture } from 'three';

import type { FileMaterial, FileTextureUse } from './file-materials.js';
import type { FileTextures, TextureMeaning } from './textures.js';

/** A material of a file. */
export type FigureMaterial = MeshStandardMaterial | MeshBasicMaterial;

/** Makes the material of a glTF material. Pictures that cannot be decoded are left out, with a line in `warnings`. */
export async function makeMaterial(
  file: FileMaterial,
  textures: FileTextures,
  vertexColors: boolean,
  warnings: string[],
): Promise<FigureMaterial> {
  const map = async (use: FileTextureUse | undefined, meaning: TextureMeaning): Promise<Texture | null> => {
    if (use === undefined) {
      return null;
    }
    try {
      return await textures.get(use, meaning);
    } catch (error) {
      warnings.push(`material ${file.name ?? ''}: texture ${use.index} is left out: ${String(error)}`);
      return null;
    }
  };
  const pbr = file.pbrMetallicRoughness ?? {};
  const [red, green, blue, alpha] = pbr.baseColorFactor ?? [1, 1, 1, 1];
  const surface = {
    name: file.name ?? '',
    color: new Color().setRGB(red, green, blue, LinearSRGBColorSpace),
    opacity: alpha,
    map: await map(pbr.baseColorTexture, 'colour'),
    vertexColors,
  };
  const unlit = file.extensions?.KHR_materials_unlit !== undefined;
  const material = unlit ? new MeshBasicMaterial(surface) : new MeshStandardMaterial(surface);
  if (material instanceof MeshStandardMaterial) {
    await addLight(material, file, map);
  }
  if (file.doubleSided === true) {
    material.side = DoubleSide;
  }
  if (file.alphaMode === 'BLEND') {
    material.transparent = true;
    material.depthWrite = false;
  } else if (file.alphaMode === 'MASK') {
    material.alphaTest = file.alphaCutoff ?? 0.5;
  } else {
    material.opacity = 1;
  }
  return material;
}

type MapOf = (use: FileTextureUse | undefined, meaning: TextureMeaning) => Promise<Texture | null>;

/** Adds what the light needs. */
async function addLight(material: MeshStandardMaterial, file: FileMaterial, map: MapOf): Promise<void> {
  const pbr = file.pbrMetallicRoughness ?? {};
  material.metalness = pbr.metallicFactor ?? 1;
  material.roughness = pbr.roughnessFactor ?? 1;
  material.metalnessMap = material.roughnessMap = await map(pbr.metallicRoughnessTexture, 'data');
  material.normalMap = await map(file.normalTexture, 'data');
  if (material.normalMap !== null) {
    const scale = file.normalTexture?.scale ?? 1;
    // Without tangents, three derives them with the other hand than glTF's.
    material.normalScale.set(scale, -scale);
  }
  material.aoMap = await map(file.occlusionTexture, 'data');
  material.aoMapIntensity = file.occlusionTexture?.strength ?? 1;
  const [red, green, blue] = file.emissiveFactor ?? [0, 0, 0];
  material.emissive.setRGB(red, green, blue, LinearSRGBColorSpace);
  material.emissiveMap = await map(file.emissiveTexture, 'colour');
  material.emissiveIntensity = file.extensions?.KHR_materials_emissive_strength?.emissiveStrength ?? 1;
}
