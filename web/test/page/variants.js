// Variants of materials in crowds and figures, beside files that have these materials as their own.
import { ArticulaFigure, ArticulaLoader } from '@articula/three';

import { madeCharacter } from './made.js';
import { compare, draw, makeStage, shown } from './stage.js';
import { theirs } from './theirs.js';

const COLUMNS = 3;
const VARIANTS = 'KHR_materials_variants';
const JSON_CHUNK = 0x4e4f534a;

/** Returns a GLB with another document. */
function edited(bytes, change) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = view.getUint32(12, true);
  const document = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
  change(document);
  const text = JSON.stringify(document);
  const json = new TextEncoder().encode(text.padEnd(text.length + ((4 - (new TextEncoder().encode(text).length % 4)) % 4)));
  const rest = bytes.subarray(20 + length);
  const made = new Uint8Array(20 + json.length + rest.length);
  made.set(bytes.subarray(0, 12));
  made.set(json, 20);
  made.set(rest, 20 + json.length);
  const header = new DataView(made.buffer);
  header.setUint32(8, made.length, true);
  header.setUint32(12, json.length, true);
  header.setUint32(16, JSON_CHUNK, true);
  return made;
}

/** Adds materials that differ by a factor, and by a picture; returns what each stands for. */
function paint(document) {
  const find = (name) => document.materials.findIndex((material) => material.name === name);
  const [lit, masked] = [find('lit'), find('masked')];
  const tinted = structuredClone(document.materials[masked]);
  tinted.name = 'tinted';
  tinted.pbrMetallicRoughness.baseColorFactor = [0.2, 0.5, 1, 1];
  const plain = { name: 'plain', pbrMetallicRoughness: { baseColorFactor: [0.8, 0.1, 0.1, 1], metallicFactor: 0 } };
  const first = document.materials.push(tinted, plain) - 2;
  return new Map([[masked, first], [lit, first + 1]]);
}

function primitives(document) {
  return document.meshes.flatMap((mesh) => mesh.primitives);
}

/** The file with a variant, and the file whose materials are those of the variant. */
async function files() {
  const bytes = await madeCharacter();
  const varied = edited(bytes, (document) => {
    const other = paint(document);
    document.extensionsUsed = [...(document.extensionsUsed ?? []), VARIANTS];
    document.extensions = { ...document.extensions, [VARIANTS]: { variants: [{ name: 'usual' }, { name: 'painted' }] } };
    for (const primitive of primitives(document)) {
      const material = other.get(primitive.material);
      if (material !== undefined) {
        const mappings = [{ material, variants: [1] }];
        primitive.extensions = { ...primitive.extensions, [VARIANTS]: { mappings } };
      }
    }
  });
  const painted = edited(bytes, (document) => {
    const other = paint(document);
    for (const primitive of primitives(document)) {
      primitive.material = other.get(primitive.material) ?? primitive.material;
    }
  });
  return [varied, painted].map((file) => URL.createObjectURL(new Blob([file])));
}

/** A crowd of which every other character shows a variant, and a figure of it. */
export async function compareVariants(renderer, kind) {
  const { ArticulaCrowd } = await import(kind === 'webgl' ? '@articula/three' : '@articula/three/webgpu');
  const [url, painted] = await files();
  const loader = new ArticulaLoader();
  loader.prepare = false;
  const [asset, usual, other] = await Promise.all([loader.loadAsync(url), theirs(url), theirs(painted)]);
  const height = asset.bounds.max.y - asset.bounds.min.y;
  const { scene, camera } = makeStage(height, COLUMNS);
  const empty = draw(renderer, scene, camera);
  const crowd = new ArticulaCrowd(asset, COLUMNS * COLUMNS, { rootMotion: 'as-authored', meshLevels: 1, poseCache: false });
  crowd.castShadow = crowd.receiveShadow = true;
  crowd.setFullDetail();
  const group = Array.from({ length: crowd.count }, (_, i) => {
    const [x, z] = [((i % COLUMNS) - 1) * 1.2 * height, (Math.floor(i / COLUMNS) - 1) * 1.2 * height];
    crowd.place(i, x, 0, z, 0.4 * i).play(i, 'wave', 0.13 * i);
    const figure = (i % 2 === 0 ? usual : other)('wave', 0.13 * i);
    figure.position.set(x, 0, z);
    figure.rotation.y = 0.4 * i;
    return figure;
  });
  scene.add(...group);
  const reference = draw(renderer, scene, camera);
  scene.remove(...group);
  scene.add(crowd);
  crowd.update(0, camera, renderer);
  const before = draw(renderer, scene, camera);
  for (let i = 1; i < crowd.count; i += 2) {
    crowd.setVariantAt(i, 'painted');
  }
  crowd.update(0, camera, renderer);
  const ours = draw(renderer, scene, camera);
  for (let i = 1; i < crowd.count; i += 2) {
    crowd.setVariantAt(i, undefined);
  }
  crowd.update(0, camera, renderer);
  const again = await compare(before, draw(renderer, scene, camera));
  scene.remove(crowd);
  const figure = new ArticulaFigure(asset).play('wave', 0.4).setVariant('painted');
  figure.mesh.castShadow = figure.mesh.receiveShadow = true;
  figure.update(0);
  const their = other('wave', 0.4);
  const pictures = [figure, their].map((object) => {
    scene.add(object);
    const picture = draw(renderer, scene, camera);
    scene.remove(object);
    return picture;
  });
  const one = await compare(pictures[1], pictures[0]);
  const found = await compare(reference, ours);
  const unknown = thrown(() => crowd.setVariantAt(0, 'gold'));
  const facts = { variants: asset.variants, warnings: asset.warnings, again: again.percent, figure: one.percent, unknown };
  const changed = (await compare(before, ours)).percent;
  figure.dispose();
  crowd.dispose();
  asset.dispose();
  return { ...found, ...facts, changed, shown: shown(empty, ours) };
}

function thrown(call) {
  try {
    call();
    return '';
  } catch (error) {
    return String(error);
  }
}
