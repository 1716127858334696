// Crowds that leave out what nobody sees, beside the same crowd with all joints.
import { ArticulaLoader } from '@articula/three';

import { compare, draw, makeStage, shown } from './stage.js';

const COLUMNS = 5;

/** Draws a crowd in full and by a tolerance of one pixel with cached poses, blended by `cache`. */
export async function compareDetail(renderer, kind, url, clip, cache) {
  const { ArticulaCrowd } = await import(kind === 'webgl' ? '@articula/three' : '@articula/three/webgpu');
  const loader = new ArticulaLoader();
  loader.prepare = false;
  const asset = await loader.loadAsync(url);
  const height = asset.bounds.max.y - asset.bounds.min.y;
  const { scene, camera } = makeStage(height, COLUMNS);
  const empty = draw(renderer, scene, camera);
  const crowd = new ArticulaCrowd(asset, COLUMNS * COLUMNS, { clips: [clip], poseCache: true });
  crowd.castShadow = crowd.receiveShadow = true;
  for (let i = 0; i < crowd.count; i += 1) {
    const [column, row] = [i % COLUMNS, Math.floor(i / COLUMNS)];
    crowd.place(i, (column - 2) * 1.2 * height, 0, (row - 2) * 1.2 * height, 0.4 * i);
    crowd.play(i, clip, 0.13 * i);
  }
  scene.add(crowd);
  // One character first, so that buffers grow when all are seen.
  const near = camera.clone();
  near.position.set(0, 0.6 * height, 0.6 * height);
  near.lookAt(0, 0.6 * height, 0);
  crowd.setFullDetail().setPoseCache('none').update(0, near, renderer);
  const close = draw(renderer, scene, near);
  const few = crowd.core.draws;
  crowd.update(0, camera, renderer);
  const full = draw(renderer, scene, camera);
  crowd.setTolerance(1).setPoseCache(cache).update(0, camera, renderer);
  const less = draw(renderer, scene, camera);
  const drawn = { palettes: crowd.core.draws, records: crowd.core.records, stepped: crowd.core.stepped };
  const levels = new Set(Array.from({ length: crowd.count }, (_, i) => crowd.levelOf(i)));
  crowd.setFullDetail().setPoseCache('none').update(0, near, renderer);
  const again = await compare(close, draw(renderer, scene, near));
  crowd.dispose();
  asset.dispose();
  const facts = { few, again: again.percent, drawn, levels: [...levels].sort() };
  return { ...(await compare(full, less)), shown: shown(empty, less), ...facts };
}
