import init, { Asset, Crowd, Figure, type InitInput } from '../wasm/play.js';
import { CrowdArrays, type ClipEvents, type CrowdOptions } from './crowd.js';
import { guarded } from './error.js';
import { FigureArrays } from './figure.js';
import { Tools, type ToolsSource } from './tools.js';

/** Where the modules are; found beside the scripts of this package if left out. */
export interface LoadOptions {
  /** The module that plays: its address, a response or its bytes. */
  readonly wasm?: InitInput | undefined;
  /** The module that prepares and converts, in a worker. */
  readonly tools?: ToolsSource | undefined;
}

/** How a figure is made. */
export interface FigureOptions {
  /** Events of clips. */
  readonly events?: ClipEvents;
  /** What becomes of the motion of the root; it stays as authored if left out. */
  readonly rootMotion?: 'in-place' | 'as-authored' | 'extracted';
}

/** One figure and its arrays. */
export interface FigureParts {
  readonly figure: Figure;
  readonly arrays: FigureArrays;
}

/** A crowd and its arrays. */
export interface CrowdParts {
  readonly crowd: Crowd;
  readonly arrays: CrowdArrays;
}

let loading: Promise<Articula> | undefined;

/** The loaded module. */
export class Articula {
  /** The module's memory. */
  readonly memory: WebAssembly.Memory;
  readonly tools: Tools;

  private constructor(memory: WebAssembly.Memory, tools: Tools) {
    this.memory = memory;
    this.tools = tools;
  }

  /** Loads the module. It is loaded once: later calls return the first, whatever their options. */
  static load(options: LoadOptions = {}): Promise<Articula> {
    loading ??= Articula.#start(options).catch((error: unknown) => {
      loading = undefined;
      throw error;
    });
    return loading;
  }

  static async #start({ wasm, tools }: LoadOptions): Promise<Articula> {
    const module = wasm ?? new URL('../wasm/play_bg.wasm', import.meta.url);
    const { memory } = await init({ module_or_path: module });
    return new Articula(memory, new Tools(tools));
  }

  /** Opens a GLB or VRM. `name` has the file's extension. */
  open(bytes: Uint8Array, name: string): Asset {
    return guarded(() => Asset.open(bytes, name));
  }

  /** Makes one character that plays. */
  figure(asset: Asset, { events, rootMotion }: FigureOptions = {}): FigureParts {
    const figure = guarded(() => new Figure(asset, rootMotion, events && JSON.stringify(events)));
    const mesh = asset.mesh();
    const { bindings } = mesh;
    mesh.free();
    return { figure, arrays: new FigureArrays(this.memory, asset, figure, bindings) };
  }

  /** Makes many instances of a character. */
  crowd(asset: Asset, count: number, options: CrowdOptions = {}): CrowdParts {
    const crowd = guarded(() => new Crowd(asset, count, JSON.stringify(options)));
    return { crowd, arrays: new CrowdArrays(this.memory, crowd, asset.morphDefaults.length) };
  }
}
