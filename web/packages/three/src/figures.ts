export { ArticulaAsset } from './asset.js';
export type { DrawnSize } from './camera-view.js';
export { type CrowdEventMap, PosedCrowd } from './crowd.js';
export { ArticulaFigure, type LayerOptions } from './figure.js';
export { FigureMesh, PaletteSkeleton } from './figure-mesh.js';
export { ArticulaLoader, type AssetSource } from './loader.js';
export type { FigureMaterial } from './materials.js';
export { ArticulaError, type CrowdOptions, type Progress } from '@articula/core';
