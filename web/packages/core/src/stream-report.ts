/** Where a stream is. `base`: the least that is shown has come; `complete`: all that its context asks for. */
export type StreamState = 'connecting' | 'base' | 'complete';

/** A file that a character carries whole, such as sound. */
export interface CarriedFile {
  /** Its name in the item. */
  readonly file: string;
  readonly bytes: number;
  /** Its media type. */
  readonly mime: string;
}

/** What is shown of a character that arrives, in numbers. */
export interface StreamReport {
  /** Level of quality of what plays, 1 to `levels`; 0 before anything is shown. */
  readonly level: number;
  /** The level that the bandwidth carries. */
  readonly target: number;
  readonly levels: number;
  /** Finest level of articulation of what plays now, 5 is the finest; undefined where it has none. */
  readonly loa: number | undefined;
  /** Joints that its layers move. */
  readonly joints: number | undefined;
  /** Finest level of the mesh that is there everywhere, 0 is the finest. */
  readonly meshLevel: number | undefined;
  /** Longer side of the coarsest texture in pixels. */
  readonly texturePx: number | undefined;
  /** Bound of the error of what plays in pixels. */
  readonly errorPx: number | undefined;
  /** Bytes that arrived, without manifests. */
  readonly bytes: number;
  /** How often playback waited for bytes. */
  readonly stalls: number;
  readonly isComplete: boolean;
}

/** A report as the module writes it. */
interface ModuleReport {
  readonly level: number;
  readonly target: number;
  readonly levels: number;
  readonly loa: number | null;
  readonly joints: number | null;
  readonly mesh_level: number | null;
  readonly texture_px: number | null;
  readonly error_px: number | null;
  readonly bytes: number;
  readonly stalls: number;
  readonly is_complete: boolean;
}

/** Reads a report of the module. */
export function readReport(json: string): StreamReport {
  const report = JSON.parse(json) as ModuleReport;
  const { level, target, levels, bytes, stalls } = report;
  return {
    level,
    target,
    levels,
    loa: report.loa ?? undefined,
    joints: report.joints ?? undefined,
    meshLevel: report.mesh_level ?? undefined,
    texturePx: report.texture_px ?? undefined,
    errorPx: report.error_px ?? undefined,
    bytes,
    stalls,
    isComplete: report.is_complete,
  };
}
