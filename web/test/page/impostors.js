// Crowds whose far characters are pictures, beside the same crowd with all joints and triangles.
import { ArticulaLoader } from '@articula/three';
import { MathUtils, OrthographicCamera } from 'three';

import { compare, draw, HEIGHT, makeStage, WIDTH } from './stage.js';

const COLUMNS = 6;
/** How far away the camera is, as of a crowd of so many columns. */
const AWAY = 12;
/** Half of the height of what the camera with parallel rays sees, in heights of a character. */
const HALF_HEIGHT = 5;
/** Levels by which a pixel that shows something differs from the empty scene. */
const SHOWN = 8;

/** An asset and its impostors, made once for all renderers. */
let making;

async function make(url, clip) {
  const loader = new ArticulaLoader();
  loader.prepare = false;
  const asset = await loader.loadAsync(url);
  const bytes = new Uint8Array(await (await fetch(url)).arrayBuffer());
  const options = { clips: [clip], maxBytes: 1 << 21, pitchesDeg: [25, 50] };
  const baked = await asset.articula.tools.impostors(bytes, 'character.glb', options);
  return { asset, ...baked };
}

/** Which pixels differ from those of the empty scene. */
function maskOf(empty, picture) {
  return Uint8Array.from({ length: WIDTH * HEIGHT }, (_, i) => {
    const differ = [0, 1, 2].some((c) => Math.abs(empty.data[4 * i + c] - picture.data[4 * i + c]) > SHOWN);
    return differ ? 1 : 0;
  });
}

/** Percentage of the pixels of a mask that are farther from another mask than so many pixels. */
function farther(mask, other, px) {
  const reach = Math.ceil(px);
  let all = 0;
  let far = 0;
  for (let at = 0; at < mask.length; at += 1) {
    if (mask[at] === 0) {
      continue;
    }
    all += 1;
    const [x, y] = [at % WIDTH, Math.floor(at / WIDTH)];
    let isNear = false;
    for (let dy = -reach; dy <= reach && !isNear; dy += 1) {
      for (let dx = -reach; dx <= reach && !isNear; dx += 1) {
        const [i, j] = [x + dx, y + dy];
        isNear = dx * dx + dy * dy <= px * px && i >= 0 && i < WIDTH && j >= 0 && j < HEIGHT && other[j * WIDTH + i] === 1;
      }
    }
    far += isNear ? 0 : 1;
  }
  return (100 * far) / Math.max(1, all);
}

/** Mean colour of the pixels of a mask. */
function meanOf(mask, picture) {
  const sum = [0, 0, 0];
  let count = 0;
  mask.forEach((shown, i) => {
    count += shown;
    sum.forEach((_, c) => {
      sum[c] += shown * picture.data[4 * i + c];
    });
  });
  return sum.map((value) => value / Math.max(1, count));
}

function parallel(camera, height) {
  const half = HALF_HEIGHT * height;
  const flat = new OrthographicCamera((-half * WIDTH) / HEIGHT, (half * WIDTH) / HEIGHT, half, -half, 0.1, 100 * height);
  flat.position.copy(camera.position);
  flat.quaternion.copy(camera.quaternion);
  return flat;
}

/** Draws a crowd in full and by impostors, by both kinds of camera; with shadows. */
export async function compareImpostors(renderer, kind, url, clip) {
  making ??= make(url, clip);
  const { asset, table, picture } = await making;
  const { ArticulaCrowd, ArticulaImpostors } = await import(kind === 'webgl' ? '@articula/three' : '@articula/three/webgpu');
  const impostors = await ArticulaImpostors.of(table, picture);
  const height = asset.bounds.max.y - asset.bounds.min.y;
  const { scene, camera } = makeStage(height, AWAY);
  scene.fog = null;
  // From the side, so that shadows lie beside who casts them.
  const sun = scene.children.find((object) => object.isDirectionalLight);
  const { shadow } = sun;
  sun.position.set(-2, 2.2, 0.3).multiplyScalar(2 * height);
  const reach = 0.75 * COLUMNS * height;
  Object.assign(shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach });
  shadow.camera.updateProjectionMatrix();
  shadow.mapSize.setScalar(1024);
  const crowd = new ArticulaCrowd(asset, COLUMNS * COLUMNS, { clips: [clip], impostors });
  crowd.castShadow = crowd.receiveShadow = true;
  crowd.position.set(0.1, 0, 0);
  crowd.rotation.y = 0.3;
  for (let i = 0; i < crowd.count; i += 1) {
    const [column, row] = [i % COLUMNS, Math.floor(i / COLUMNS)];
    crowd.place(i, (column - 2.5) * height, 0, (row - 2.5) * height, 0.7 * i);
    crowd.play(i, clip, 0.13 * i);
  }
  // The error of these impostors where they are nearest.
  const nearest = camera.position.length() - COLUMNS * height;
  const pixelsPerMetre = HEIGHT / 2 / Math.tan(MathUtils.degToRad(camera.fov / 2)) / nearest;
  const tolerance = 1.05 * table.clips[0].error_m * Math.max(pixelsPerMetre, HEIGHT / 2 / HALF_HEIGHT / height);
  const views = [];
  let shownBy;
  for (const eye of [camera, parallel(camera, height)]) {
    const empty = draw(renderer, scene, eye);
    scene.add(crowd);
    crowd.setFullDetail().setPoseCache('none').update(0, eye, renderer);
    const full = draw(renderer, scene, eye);
    crowd.setPoseCache('cpu').setTolerance(tolerance).update(0, eye, renderer);
    const far = draw(renderer, scene, eye);
    const [theirs, ours] = [maskOf(empty, full), maskOf(empty, far)];
    // What is drawn at a pixel may reach into the next.
    const px = tolerance + 1;
    shownBy ??= ours;
    views.push({
      impostors: crowd.core.impostors,
      share: (100 * theirs.reduce((sum, shown) => sum + shown, 0)) / theirs.length,
      lost: farther(theirs, ours, px),
      added: farther(ours, theirs, px),
      means: [meanOf(theirs, full), meanOf(ours, far)],
      png: (await compare(full, far)).png,
    });
    crowd.removeFromParent();
  }
  for (let i = 0; i < crowd.count; i += 1) {
    crowd.setColorAt(i, 0xff0000);
  }
  scene.add(crowd);
  crowd.update(0, camera, renderer);
  const tinted = meanOf(shownBy, draw(renderer, scene, camera));
  // Seen from nearby they are meshes.
  const near = camera.clone();
  near.position.multiplyScalar(0.1);
  crowd.update(0, near, renderer);
  const facts = { tolerance, usual: views[0].means[1], count: crowd.count, nearby: crowd.core.impostors, errorM: table.clips[0].error_m, tinted };
  crowd.dispose();
  impostors.dispose();
  return { views, ...facts };
}
