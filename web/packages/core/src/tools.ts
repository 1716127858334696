import { ArticulaError } from './error.js';
import type { Progress, Reply, Request, Task } from './messages.js';

/** How a task in a worker is watched and ended. */
export interface TaskOptions {
  readonly onProgress?: ((progress: Progress) => void) | undefined;
  /** Ends the task: it rejects with an {@link ArticulaError} of code `cancelled`. */
  readonly signal?: AbortSignal | undefined;
}

/** Where the worker and its module are; found beside this script if left out. */
export interface ToolsSource {
  readonly worker?: (() => Worker) | undefined;
  readonly wasm?: string | URL | undefined;
}

/** Functions that take seconds. Each call runs in a worker of its own. */
export class Tools {
  readonly #source: ToolsSource;

  constructor(source: ToolsSource = {}) {
    this.#source = source;
  }

  /** Returns the file with all tables that playing it needs: it then opens at once. */
  prepare(
    bytes: Uint8Array,
    name: string,
    options: { readonly meshLevels?: number } & TaskOptions = {},
  ): Promise<Uint8Array> {
    const { meshLevels } = options;
    return this.#run({ call: 'prepare', bytes, name, options: JSON.stringify({ meshLevels }) }, options);
  }

  /** Returns a character or motion as a file with the extension `to`. */
  convert(bytes: Uint8Array, name: string, to: string, options: TaskOptions = {}): Promise<Uint8Array> {
    return this.#run({ call: 'convert', bytes, name, to, options: '{}' }, options);
  }

  /** Returns the character with the clips of a motion file, retargeted. */
  addClips(
    bytes: Uint8Array,
    name: string,
    motion: Uint8Array,
    motionName: string,
    options: TaskOptions = {},
  ): Promise<Uint8Array> {
    return this.#run({ call: 'addClips', bytes, name, motion, motionName, options: '{}' }, options);
  }

  /** Returns the character as a movie or picture of 2D shapes. */
  flatten(bytes: Uint8Array, name: string, options: FlattenOptions & TaskOptions): Promise<Uint8Array> {
    const { onProgress: _progress, signal: _signal, ...flatten } = options;
    return this.#run({ call: 'flatten', bytes, name, options: JSON.stringify(flatten) }, options);
  }

  #run(task: Task, { onProgress, signal }: TaskOptions): Promise<Uint8Array> {
    const cancelled = (): ArticulaError =>
      new ArticulaError({ code: 'cancelled', message: `${task.name}: cancelled`, file: task.name });
    if (signal?.aborted) {
      return Promise.reject(cancelled());
    }
    const worker = this.#source.worker?.() ?? new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    return new Promise<Uint8Array>((resolve, reject) => {
      const abort = (): void => reject(cancelled());
      signal?.addEventListener('abort', abort, { once: true });
      worker.onmessage = ({ data }: MessageEvent<Reply>) => {
        if ('progress' in data) {
          onProgress?.(data.progress);
        } else if ('result' in data) {
          resolve(data.result);
        } else if ('fault' in data) {
          reject(new ArticulaError(data.fault));
        } else {
          reject(new Error(data.failure));
        }
      };
      worker.onerror = (event) => reject(new Error(`the worker failed: ${event.message || 'its script was not found'}`));
      const request: Request = { task, wasm: this.#source.wasm?.toString() };
      worker.postMessage(request);
    }).finally(() => worker.terminate());
  }
}

/** What {@link Tools.flatten} makes. */
export interface FlattenOptions {
  readonly form: 'svg' | 'player' | 'lottie';
  readonly clip?: string;
  readonly yawDeg?: number;
  readonly triangles?: number;
  readonly maxBytes?: number;
}
