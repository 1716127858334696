/** For `WebGLRenderer`. The entry `@articula/three/webgpu` has the same for `WebGPURenderer`. */
import type { ArticulaAsset } from './asset.js';
import { type CrowdOptions, PosedCrowd } from './crowd.js';
import { GlslShading } from './crowd-glsl.js';

export * from './figures.js';

/** Many instances of one character, for `WebGLRenderer`. */
export class ArticulaCrowd extends PosedCrowd {
  constructor(asset: ArticulaAsset, count: number, options: CrowdOptions = {}) {
    super(asset, count, new GlslShading(), options);
  }
}
