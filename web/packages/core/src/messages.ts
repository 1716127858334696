import type { ArticulaFault } from './error.js';
import type { RecordedFrames } from './tools.js';

/** How far a task is. */
export interface Progress {
  /** What is done now. */
  readonly part: string;
  readonly done: number;
  readonly total: number;
}

/** A file with its report, as JSON. */
export interface MeasuredBytes {
  readonly bytes: Uint8Array;
  readonly report: string;
}

/** A file of a digital item. */
export interface PackagedBytes {
  readonly name: string;
  readonly bytes: Uint8Array;
}

interface FileTask<Call extends string> {
  readonly call: Call;
  readonly bytes: Uint8Array;
  readonly name: string;
  /** JSON. */
  readonly options: string;
}

/** A call of a function of the tools. */
export type Task =
  | FileTask<'prepare'>
  | FileTask<'flatten'>
  | FileTask<'flattenMeasured'>
  | FileTask<'evaluate'>
  | FileTask<'errorMatrix'>
  | FileTask<'optimize'>
  | FileTask<'benchmark'>
  | FileTask<'inspect'>
  | FileTask<'package'>
  | FileTask<'portrait'>
  | FileTask<'impostors'>
  | FileTask<'encode'>
  | FileTask<'encodeFace'>
  | (FileTask<'convert'> & { readonly to: string })
  | (FileTask<'addFaceClip'> & { readonly motion: Uint8Array; readonly motionName: string })
  | (FileTask<'addVoice'> & { readonly voice: Uint8Array; readonly voiceName: string })
  | (FileTask<'addRecording'> & { readonly recording: RecordedFrames })
  | (FileTask<'addClips'> & { readonly motion: Uint8Array; readonly motionName: string });

/** What a task returns. */
export type TaskResult<Call extends Task['call']> = Call extends 'inspect' | 'evaluate' | 'benchmark'
  ? string
  : Call extends 'package' | 'portrait' | 'impostors' | 'encode' | 'encodeFace'
    ? PackagedBytes[]
    : Call extends 'flattenMeasured' | 'optimize'
      ? MeasuredBytes
      : Call extends 'errorMatrix'
        ? Float32Array
        : Uint8Array;

/** What the page sends to a worker. */
export interface Request {
  readonly task: Task;
  /** Where the module is, if not beside its script. */
  readonly wasm: string | undefined;
}

/** What a worker sends to the page: progress, and one result or fault at the end. */
export type Reply =
  | { readonly progress: Progress }
  | { readonly result: TaskResult<Task['call']> }
  | { readonly fault: ArticulaFault }
  | { readonly failure: string };
