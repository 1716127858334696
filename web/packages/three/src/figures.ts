export { ArticulaAsset } from './asset.js';
export type { DrawnSize } from './camera-view.js';
export { type CrowdEventMap, PosedCrowd } from './crowd.js';
export { ArticulaFigure, type FigureEventMap, type LayerOptions } from './figure.js';
export { FigureMesh, PaletteSkeleton } from './figure-mesh.js';
export { ArticulaLoader, type AssetSource } from './loader.js';
export type { FigureMaterial } from './materials.js';
export { ArticulaStream, type StreamEventMap } from './stream.js';
export type { StreamContext, StreamOptions, StreamReport, StreamState } from '@articula/core/stream';
export {
  ArticulaError,
  type ClipEvent,
  type ClipEvents,
  type CrowdOptions,
  type FigureOptions,
  type Progress,
} from '@articula/core';
