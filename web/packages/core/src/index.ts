/// <reference lib="esnext.disposable" preserve="true" />
export { Asset, Crowd, Figure, Geometry } from '../wasm/play.js';
export { Articula, type CrowdParts, type FigureOptions, type FigureParts, type LoadOptions } from './articula.js';
export { type ClipEvent, type ClipEvents, CrowdArrays, type CrowdOptions, type DrawGroup, type DrawKind } from './crowd.js';
export { ArticulaError, type ArticulaErrorCode, type ArticulaFault } from './error.js';
export { FigureArrays, type FigureLengths, type FigureOffsets, MATRIX_FLOATS } from './figure.js';
export type { ImpostorTable } from './impostors.js';
export type { PackagedBytes, Progress } from './messages.js';
export {
  type AddClipsOptions,
  type BenchmarkOptions,
  type ConvertOptions,
  type EncodeOptions,
  type ErrorMatrixOptions,
  type EvaluateOptions,
  type FlattenOptions,
  type ImpostorFiles,
  type ImpostorOptions,
  type MeasuredFile,
  type OptimizeOptions,
  type PackageOptions,
  type PortraitFiles,
  type PortraitOptions,
  type PrepareOptions,
  type RecordedFrames,
  type TaskOptions,
  Tools,
  type ToolsSource,
} from './tools.js';
export { packViews, VIEW_FLOATS, type View } from './view.js';
