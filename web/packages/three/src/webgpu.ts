/** For `WebGPURenderer`, with WebGPU and with WebGL 2. */
import type { ArticulaAsset } from './asset.js';
import { type CrowdOptions, PosedCrowd } from './crowd.js';
import { NodeShading } from './crowd-nodes.js';

export * from './figures.js';

/** Many instances of one character, for `WebGPURenderer`. */
export class ArticulaCrowd extends PosedCrowd {
  constructor(asset: ArticulaAsset, count: number, options: CrowdOptions = {}) {
    super(asset, count, new NodeShading(), options);
  }
}
