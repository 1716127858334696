import type { LoadOptions } from '@articula/core';
import publishUrl from '@articula/core/publish_bg.wasm?url';
import publisherUrl from '@articula/core/publisher?worker&url';
import toolsUrl from '@articula/core/tools_bg.wasm?url';
import workerUrl from '@articula/core/worker?worker&url';

type ToolsSource = NonNullable<LoadOptions['tools']>;

/** Addresses of the scripts of the workers and of their modules. */
interface Addresses {
  worker: string;
  wasm: string;
  publisher: string;
  publishWasm: string;
}

const SCRIPT = 'text/javascript';
const MODULE = 'application/wasm';
const TYPES: Readonly<Record<keyof Addresses, string>> = {
  worker: SCRIPT,
  wasm: MODULE,
  publisher: SCRIPT,
  publishWasm: MODULE,
};

/**
 * Where the tools are: on the server, until they are kept. They are large, so a page that begins does not wait for
 * them; once kept they work without a network.
 */
export class KeptTools {
  readonly #at: Addresses = {
    worker: absolute(workerUrl),
    wasm: absolute(toolsUrl),
    publisher: absolute(publisherUrl),
    publishWasm: absolute(publishUrl),
  };
  #kept: Promise<void> | undefined;

  /** For `Articula.load`, which asks for it at each use. */
  get source(): ToolsSource {
    const at = this.#at;
    return {
      worker: () => new Worker(at.worker, { type: 'module' }),
      publisher: () => new Worker(at.publisher, { type: 'module' }),
      get wasm() {
        return at.wasm;
      },
      get publishWasm() {
        return at.publishWasm;
      },
    };
  }

  /** Fetches all that later work needs. A failure leaves it to that work. */
  keep(): Promise<void> {
    this.#kept ??= Promise.all([this.#fetch(), import('lottie-web/build/player/lottie_light')]).then(
      () => {},
      () => {
        this.#kept = undefined;
      },
    );
    return this.#kept;
  }

  async #fetch(): Promise<void> {
    const names = Object.keys(TYPES) as (keyof Addresses)[];
    await Promise.all(
      names.map(async (name) => {
        this.#at[name] = await blobOf(this.#at[name], TYPES[name]);
      }),
    );
  }
}

function absolute(url: string): string {
  return new URL(url, location.href).href;
}

async function blobOf(url: string, type: string): Promise<string> {
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${url}: the server answers ${response.status}`);
  }
  return URL.createObjectURL(new Blob([await response.arrayBuffer()], { type }));
}
