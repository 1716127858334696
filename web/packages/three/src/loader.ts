import { Articula, type LoadOptions, type Progress } from '@articula/core';
import { FileLoader, Loader, type LoadingManager } from 'three';

import { ArticulaAsset } from './asset.js';

/** What can be loaded: an address, or a file that the page has. */
export type AssetSource = string | Blob | ArrayBuffer | Uint8Array;

/** Names of files that are opened without a worker. */
const IS_PLAYED = /\.(glb|vrm)$/i;

/**
 * Loads characters. An asset that is prepared opens at once; another GLB or VRM, and files of all other formats, are
 * prepared in a worker first, which takes seconds: see {@link ArticulaLoader.onPrepare} and
 * {@link ArticulaLoader.prepare}.
 */
export class ArticulaLoader extends Loader<ArticulaAsset, AssetSource> {
  readonly #options: LoadOptions;
  /** Whether a GLB or VRM that is not prepared is. Figures do not need it; a crowd is then made faster. */
  prepare = true;
  /** Levels of the mesh to make if the file is prepared: see `PrepareOptions` of `@articula/core`. */
  meshLevels: number | undefined;
  /** Ends preparing. */
  signal: AbortSignal | undefined;
  /** Is told how far preparing is. */
  onPrepare: ((progress: Progress) => void) | undefined;

  constructor(manager?: LoadingManager, options: LoadOptions = {}) {
    super(manager);
    this.#options = options;
  }

  override load(
    source: AssetSource,
    onLoad: (asset: ArticulaAsset) => void,
    onProgress?: (event: ProgressEvent) => void,
    onError?: (error: unknown) => void,
  ): void {
    const item = typeof source === 'string' ? source : nameOf(source);
    this.manager.itemStart(item);
    this.#open(source, onProgress)
      .then(onLoad)
      .catch((error: unknown) => {
        this.manager.itemError(item);
        if (onError === undefined) {
          console.error(error);
        } else {
          onError(error);
        }
      })
      .finally(() => this.manager.itemEnd(item));
  }

  override loadAsync(source: AssetSource, onProgress?: (event: ProgressEvent) => void): Promise<ArticulaAsset> {
    return new Promise((resolve, reject) => this.load(source, resolve, onProgress, reject));
  }

  async #open(source: AssetSource, onProgress?: (event: ProgressEvent) => void): Promise<ArticulaAsset> {
    const [articula, file] = await Promise.all([
      Articula.load(this.#options),
      typeof source === 'string' ? this.#fetch(source, onProgress) : bytesOf(source),
    ]);
    const name = nameOf(source);
    if (IS_PLAYED.test(name)) {
      const core = articula.open(file, name);
      if (core.isPrepared || !this.prepare) {
        return ArticulaAsset.of(articula, core);
      }
      core.free();
    }
    const { signal, onPrepare, meshLevels } = this;
    const prepared = await articula.tools.prepare(file, name, { signal, onProgress: onPrepare, meshLevels });
    return ArticulaAsset.of(articula, articula.open(prepared, IS_PLAYED.test(name) ? name : `${name}.glb`));
  }

  async #fetch(url: string, onProgress?: (event: ProgressEvent) => void): Promise<Uint8Array> {
    const loader = new FileLoader(this.manager);
    loader.setPath(this.path);
    loader.setResponseType('arraybuffer');
    loader.setRequestHeader(this.requestHeader);
    loader.setWithCredentials(this.withCredentials);
    const data = await loader.loadAsync(url, onProgress);
    return new Uint8Array(data as ArrayBuffer);
  }
}

async function bytesOf(source: Exclude<AssetSource, string>): Promise<Uint8Array> {
  if (source instanceof Uint8Array) {
    return source;
  }
  return new Uint8Array(source instanceof Blob ? await source.arrayBuffer() : source);
}

/** The name of a source, with an extension: that of GLB if it has none. */
function nameOf(source: AssetSource): string {
  if (source instanceof File) {
    return source.name;
  }
  const path = typeof source === 'string' ? (source.split(/[?#]/)[0] ?? '') : '';
  const name = path.split('/').at(-1) ?? '';
  return name.includes('.') ? decodeURIComponent(name) : 'character.glb';
}
