export { ArticulaAsset } from './asset.js';
export type { DrawnSize } from './camera-view.js';
export { type CrowdEventMap, type CrowdOptions, PosedCrowd } from './crowd.js';
export { ArticulaFigure, type FigureEventMap, type LayerOptions } from './figure.js';
export { FigureMesh, PaletteSkeleton } from './figure-mesh.js';
export { ArticulaImpostors, type ImpostorShape } from './impostors.js';
export { ArticulaLoader, type AssetSource } from './loader.js';
export type { FigureMaterial } from './materials.js';
export { ArticulaStream, type StreamEventMap } from './stream.js';
export type { StreamContext, StreamOptions, StreamReport, StreamState } from '@articula/core/stream';
export {
  ArticulaError,
  type ClipEvent,
  type ClipEvents,
  type FigureOptions,
  type ImpostorTable,
  type Progress,
} from '@articula/core';
