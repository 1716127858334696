/** Characters of a server, while they arrive. The module is loaded with the first stream. */
import init, { type Arrival, type Asset, Client, type InitInput } from '../wasm/stream.js';
import { ArticulaError, guarded } from './error.js';
import { FigureArrays } from './figure.js';
import { HttpLink } from './stream-http.js';
import type { StreamLink } from './stream-link.js';
import { type CarriedFile, readReport, type StreamReport, type StreamState } from './stream-report.js';
import { SessionLink } from './stream-session.js';

export { Arrival, Asset } from '../wasm/stream.js';
export { ArticulaError } from './error.js';
export type { CarriedFile, StreamReport, StreamState } from './stream-report.js';

/** What is known of network, device and viewer; all of it may be left out. */
export interface StreamContext {
  readonly network?: { readonly available_bps?: number };
  readonly terminal?: {
    readonly width_px?: number;
    readonly height_px?: number;
    readonly frame_budget_ms?: number;
    readonly memory_bytes?: number;
  };
  readonly preferences?: { readonly tolerance_px?: number; readonly body_loa?: number; readonly mesh_level?: number };
  readonly view?: { readonly distance_m?: number; readonly fov_rad?: number };
}

/** How a character is asked for. */
export interface StreamOptions {
  /** Over HTTP, where the page decides what to fetch, or in a session, where the server does. */
  readonly by?: 'http' | 'session';
  /** The clip to play; the first if left out. */
  readonly clip?: string | undefined;
  readonly context?: StreamContext;
  /** Where the module is; found beside this script if left out. */
  readonly wasm?: InitInput | undefined;
}

/** Who hears of a stream. */
export interface StreamListener {
  state?(state: StreamState): void;
  /** Bytes have come. */
  progress?(report: StreamReport): void;
  /** The server is not reached; it is tried again. */
  lost?(why: string): void;
  /** The stream has ended with an error. */
  error?(error: ArticulaError): void;
}

/** What is shown of a character until something finer replaces it. */
export interface ArrivedParts {
  readonly arrival: Arrival;
  readonly asset: Asset;
  readonly arrays: FigureArrays;
}

let loading: Promise<WebAssembly.Memory> | undefined;

/** Loads the module once. */
function load(wasm: InitInput | undefined): Promise<WebAssembly.Memory> {
  loading ??= init({ module_or_path: wasm ?? new URL('../wasm/stream_bg.wasm', import.meta.url) })
    .then(({ memory }) => memory)
    .catch((error: unknown) => {
      loading = undefined;
      throw error;
    });
  return loading;
}

/** A character of a server: it is fetched, played and refined. */
export class CharacterStream {
  readonly name: string;
  readonly #memory: WebAssembly.Memory;
  readonly #client: Client;
  readonly #listener: StreamListener;
  readonly #link: StreamLink;
  #state: StreamState = 'connecting';
  #isEnded = false;

  private constructor(
    server: URL,
    name: string,
    memory: WebAssembly.Memory,
    { clip, by, context }: StreamOptions,
    listener: StreamListener,
  ) {
    this.name = name;
    this.#memory = memory;
    this.#listener = listener;
    this.#client = guarded(() => new Client(JSON.stringify(context ?? {})));
    this.#client.add(name);
    if (clip !== undefined) {
      this.#client.play(0, clip, 0, now());
    }
    const linked = {
      client: this.#client,
      server,
      now,
      arrived: () => this.#arrived(),
      lost: (why: string) => listener.lost?.(why),
      failed: (error: unknown) => this.#failed(error),
    };
    this.#link = by === 'session' ? new SessionLink(linked) : new HttpLink(linked);
    this.#link.ask();
  }

  /** Begins to fetch a character of a server by its name there. */
  static async open(
    server: string | URL,
    name: string,
    options: StreamOptions = {},
    listener: StreamListener = {},
  ): Promise<CharacterStream> {
    const memory = await load(options.wasm);
    const address = new URL(server, typeof document === 'undefined' ? undefined : document.baseURI);
    if (!address.pathname.endsWith('/')) {
      address.pathname += '/';
    }
    return new CharacterStream(address, name, memory, options, listener);
  }

  get state(): StreamState {
    return this.#state;
  }

  /** Changes whenever {@link arrived} has something finer; 0 before there is anything. */
  get version(): number {
    return this.#isEnded ? 0 : this.#client.version(0);
  }

  /** Names of the clips, those too that have not come; empty before the server has told. */
  get clips(): readonly string[] {
    return this.#isEnded ? [] : this.#client.clips(0);
  }

  /** Name of the clip that plays; undefined before one does. */
  get clip(): string | undefined {
    return this.#isEnded ? undefined : this.#client.clip(0);
  }

  /** Time within it in seconds. */
  get clipSecs(): number {
    return this.#isEnded ? 0 : this.#client.clipSecs(0);
  }

  /** Files that it carries whole, those too that have not come; none before the server has told. */
  get carried(): readonly CarriedFile[] {
    return this.#isEnded ? [] : (JSON.parse(this.#client.carried(0)) as CarriedFile[]);
  }

  /** Bytes of a file that it carries; undefined until it has come. */
  carriedFile(file: string): Uint8Array | undefined {
    return this.#isEnded ? undefined : this.#client.carriedFile(0, file);
  }

  /** What is shown, in numbers; undefined once it has ended. */
  get report(): StreamReport | undefined {
    return this.#isEnded ? undefined : readReport(this.#client.report(0));
  }

  /** What is shown now; undefined before the base is here. Free `arrival` and `asset` of it. */
  arrived(): ArrivedParts | undefined {
    const arrival = this.#isEnded ? undefined : this.#client.arrival(0);
    if (arrival === undefined) {
      return undefined;
    }
    const asset = arrival.asset();
    const mesh = asset.mesh();
    const { bindings } = mesh;
    mesh.free();
    return { arrival, asset, arrays: new FigureArrays(this.#memory, asset, arrival, bindings) };
  }

  /** Poses what is shown as the last frame plays. */
  pose({ arrival }: ArrivedParts): void {
    if (!this.#isEnded) {
      arrival.pose(this.#client, 0);
    }
  }

  /** Plays a clip, from `secs` on. */
  play(clip: string, secs = 0): void {
    if (!this.#isEnded) {
      this.#client.play(0, clip, secs, now());
      this.#link.ask();
    }
  }

  /** Tells how far the camera is in metres: what is not seen is not fetched. */
  setDistance(metres: number): void {
    this.#guard(() => this.#client.setView(0, 1, metres));
  }

  /** Tells what has changed of network, device or viewer: all of it, as at first. */
  setContext(context: StreamContext): void {
    this.#guard(() => this.#client.setContext(JSON.stringify(context), now()));
  }

  /** Moves time on by a step, shows what has come, and asks for more. */
  frame(dtSecs: number): void {
    this.#guard(() => this.#client.frame(now(), dtSecs));
    if (!this.#isEnded) {
      this.#link.ask();
      this.#tell();
    }
  }

  /** Ends all that is under way, and releases the client. */
  dispose(): void {
    if (!this.#isEnded) {
      this.#isEnded = true;
      this.#link.close();
      this.#client.free();
    }
  }

  #arrived(): void {
    if (this.#isEnded) {
      return;
    }
    const fault = this.#client.fault(0);
    if (fault !== undefined) {
      this.#failed(new ArticulaError({ code: 'invalid', message: `${this.name}: ${fault}`, file: this.name }));
      return;
    }
    // Pages may draw nothing before there is something to draw.
    if (this.#state === 'connecting') {
      this.#guard(() => this.#client.frame(now(), 0));
      this.#tell();
    }
    const { report } = this;
    if (report !== undefined) {
      this.#listener.progress?.(report);
    }
  }

  #tell(): void {
    if (this.#isEnded) {
      return;
    }
    const shown = this.version > 0 ? 'base' : 'connecting';
    const state = shown === 'base' && this.report?.isComplete === true ? 'complete' : shown;
    if (state !== this.#state) {
      this.#state = state;
      this.#listener.state?.(state);
    }
  }

  #guard(work: () => void): void {
    if (this.#isEnded) {
      return;
    }
    try {
      guarded(work);
    } catch (error) {
      this.#failed(error);
    }
  }

  #failed(error: unknown): void {
    if (this.#isEnded) {
      return;
    }
    this.dispose();
    const message = error instanceof Error ? error.message : String(error);
    const own = error instanceof ArticulaError ? error : new ArticulaError({ code: 'invalid', message }, error);
    this.#listener.error?.(own);
  }
}

/** Seconds on the clock of the page. */
function now(): number {
  return performance.now() / 1000;
}
