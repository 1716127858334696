// A figure and a crowd beside what three.js shows of the same file.
import { ArticulaFigure, ArticulaLoader } from '@articula/three';

import { compare, draw, makeStage, shown } from './stage.js';
import { theirs } from './theirs.js';

const COLUMNS = 3;

/** Compares one file in one renderer. */
export async function comparePictures(renderer, kind, url, clip, hasLamp = false) {
  const { ArticulaCrowd } = await import(kind === 'webgl' ? '@articula/three' : '@articula/three/webgpu');
  const loader = new ArticulaLoader();
  loader.prepare = false;
  const [asset, makeTheirs] = await Promise.all([loader.loadAsync(url), theirs(url)]);
  const height = asset.bounds.max.y - asset.bounds.min.y;
  const [one, many] = [1, COLUMNS].map((columns) => makeStage(height, columns, hasLamp));
  const figure = await figureBeside(renderer, asset, makeTheirs, one, clip);
  const crowd = await crowdBeside(renderer, asset, makeTheirs, many, clip, ArticulaCrowd);
  const warnings = [...asset.warnings];
  asset.dispose();
  return { figure, crowd, warnings };
}

async function figureBeside(renderer, asset, makeTheirs, { scene, camera }, clip) {
  const empty = draw(renderer, scene, camera);
  const secs = 0.4;
  const their = makeTheirs(clip, secs);
  scene.add(their);
  const reference = draw(renderer, scene, camera);
  scene.remove(their);
  const figure = new ArticulaFigure(asset);
  figure.mesh.castShadow = figure.mesh.receiveShadow = true;
  if (clip !== undefined) {
    figure.play(clip, secs);
  }
  figure.update(0);
  scene.add(figure);
  const ours = draw(renderer, scene, camera);
  figure.dispose();
  return { ...(await compare(reference, ours)), shown: shown(empty, ours) };
}

async function crowdBeside(renderer, asset, makeTheirs, { scene, camera }, clip, ArticulaCrowd) {
  const height = asset.bounds.max.y - asset.bounds.min.y;
  const empty = draw(renderer, scene, camera);
  const places = Array.from({ length: COLUMNS * COLUMNS }, (_, i) => ({
    x: ((i % COLUMNS) - 1) * 1.2 * height,
    z: (Math.floor(i / COLUMNS) - 1) * 1.2 * height,
    yaw: 0.4 * i,
    secs: 0.13 * i,
  }));
  const group = places.map(({ x, z, yaw, secs }) => {
    const figure = makeTheirs(clip, secs);
    figure.position.set(x, 0, z);
    figure.rotation.y = yaw;
    scene.add(figure);
    return figure;
  });
  const reference = draw(renderer, scene, camera);
  group.forEach((figure) => scene.remove(figure));
  const crowd = new ArticulaCrowd(asset, places.length, { rootMotion: 'as-authored', meshLevels: 1, poseCache: false });
  crowd.castShadow = crowd.receiveShadow = true;
  crowd.setFullDetail();
  places.forEach(({ x, z, yaw, secs }, i) => {
    crowd.place(i, x, 0, z, yaw);
    if (clip !== undefined) {
      crowd.play(i, clip, secs);
    }
  });
  crowd.update(0, camera, renderer);
  scene.add(crowd);
  const ours = draw(renderer, scene, camera);
  const draws = crowd.children.filter((mesh) => mesh.visible).length;
  crowd.dispose();
  return { ...(await compare(reference, ours)), shown: shown(empty, ours), draws };
}
