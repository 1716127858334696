import type { ArticulaFault } from './error.js';

/** How far a worker is. */
export interface Progress {
  /** What is done now. */
  readonly part: string;
  readonly done: number;
  readonly total: number;
}

/** A call of a function of the tools. */
export type Task =
  | { readonly call: 'prepare'; readonly bytes: Uint8Array; readonly name: string; readonly options: string }
  | {
      readonly call: 'convert';
      readonly bytes: Uint8Array;
      readonly name: string;
      readonly to: string;
      readonly options: string;
    }
  | {
      readonly call: 'addClips';
      readonly bytes: Uint8Array;
      readonly name: string;
      readonly motion: Uint8Array;
      readonly motionName: string;
      readonly options: string;
    }
  | { readonly call: 'flatten'; readonly bytes: Uint8Array; readonly name: string; readonly options: string };

/** What the page sends to a worker. */
export interface Request {
  readonly task: Task;
  /** Where the module is, if not beside its script. */
  readonly wasm: string | undefined;
}

/** What a worker sends to the page: progress, and one result or fault at the end. */
export type Reply =
  | { readonly progress: Progress }
  | { readonly result: Uint8Array }
  | { readonly fault: ArticulaFault }
  | { readonly failure: string };
