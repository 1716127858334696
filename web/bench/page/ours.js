// Crowds of this library, by the class that a page uses: its update plans, evaluates and fills the arrays of three.js.
import { ArticulaCrowd } from '@articula/three';

import { character } from './scene.js';

/** How a crowd chooses details. */
export const KINDS = {
  'all joints': (crowd) => crowd.setPoseCache('none').setFullDetail(),
  '1 px, blended by the CPU': (crowd) => crowd.setPoseCache('cpu').setTolerance(1),
  '1 px, blended by the GPU': (crowd) => crowd.setPoseCache('gpu').setTolerance(1),
};

export function makeCrowd(asset, clip, count, kind, rootMotion, poseCache = true) {
  const crowd = new ArticulaCrowd(asset, count, { rootMotion, poseCache });
  KINDS[kind](crowd);
  for (let i = 0; i < count; i += 1) {
    const { x, z, secs } = character(i, count);
    crowd.place(i, x, 0, z).play(i, clip, secs);
  }
  return crowd;
}

/** Bytes that the last frame gives the GPU. */
export function bytesOf({ core }) {
  return 48 * core.paletteMatrices + 8 * core.draws + 16 * core.records + 8 * core.stepped;
}
