import type { LoadOptions } from '@articula/core';
import wasmUrl from '@articula/core/tools_bg.wasm?url';
import workerUrl from '@articula/core/worker?worker&url';

type ToolsSource = NonNullable<LoadOptions['tools']>;

/**
 * Where the tools are: on the server, until they are kept. They are large, so a page that begins does not wait for
 * them; once kept they work without a network.
 */
export class KeptTools {
  #worker = new URL(workerUrl, location.href).href;
  #wasm = new URL(wasmUrl, location.href).href;
  #kept: Promise<void> | undefined;

  /** For `Articula.load`, which asks for it at each use. */
  get source(): ToolsSource {
    const worker = (): Worker => new Worker(this.#worker, { type: 'module' });
    const wasm = (): string => this.#wasm;
    return {
      worker,
      get wasm() {
        return wasm();
      },
    };
  }

  /** Fetches all that later work needs. A failure leaves it to that work. */
  keep(): Promise<void> {
    this.#kept ??= Promise.all([
      blobOf(this.#worker, 'text/javascript').then((url) => {
        this.#worker = url;
      }),
      blobOf(this.#wasm, 'application/wasm').then((url) => {
        this.#wasm = url;
      }),
      import('lottie-web/build/player/lottie_light'),
    ]).then(
      () => {},
      () => {
        this.#kept = undefined;
      },
    );
    return this.#kept;
  }
}

async function blobOf(url: string, type: string): Promise<string> {
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${url}: the server answers ${response.status}`);
  }
  return URL.createObjectURL(new Blob([await response.arrayBuffer()], { type }));
}
