import type { Request } from '../wasm/stream.js';
import { ArticulaError, guarded } from './error.js';
import type { LinkedStream, StreamLink } from './stream-link.js';

/** How long the server may wait for the next stage of a character, seconds. */
const WAIT_SECS = 30;
/** After a request that failed the client is asked again so often, milliseconds; it pauses by itself. */
const RETRY_MS = 250;

/** Fetches manifests and ranges over HTTP: the client decides what. */
export class HttpLink implements StreamLink {
  readonly #stream: LinkedStream;
  readonly #ended = new AbortController();

  constructor(stream: LinkedStream) {
    this.#stream = stream;
  }

  ask(): void {
    const { client } = this.#stream;
    while (!this.#ended.signal.aborted) {
      const request = client.request(this.#stream.now());
      if (request === undefined) {
        return;
      }
      const { id, manifest } = request;
      const fetched = manifest === undefined ? this.#bytes(id, request) : this.#manifest(id, manifest, request.known);
      request.free();
      fetched.catch((error: unknown) => this.#failed(id, error)).finally(() => this.#next());
    }
  }

  close(): void {
    this.#ended.abort();
  }

  async #manifest(id: number, name: string, known: string | undefined): Promise<void> {
    const { client, server } = this.#stream;
    const path = `v1/characters/${encodeURIComponent(name)}/manifest.json?wait=${WAIT_SECS}`;
    const headers = known === undefined ? {} : { 'If-None-Match': `"${known}"` };
    const answer = await this.#fetch(new URL(path, server), headers);
    const isWhole = answer.headers.get('Articula-State') === 'ready';
    if (answer.status === 304 || answer.status === 503) {
      guarded(() => client.answerUnchanged(id, isWhole, this.#stream.now()));
      return;
    }
    if (answer.status >= 400 && answer.status < 500) {
      throw new ArticulaError({
        code: answer.status === 404 ? 'missing' : 'invalid',
        message: `${name}: ${await reason(answer)}`,
        file: name,
      });
    }
    const bytes = await bytesOf(answer, 200);
    this.#taken(() => client.answerManifest(id, bytes, isWhole, this.#stream.now()));
  }

  async #bytes(id: number, { object, isWhole, start, end }: Request): Promise<void> {
    const { client, server } = this.#stream;
    // The browser asks for a compressed body by itself, but not of a range.
    const headers = isWhole ? {} : { Range: `bytes=${start}-${end - 1}` };
    const answer = await this.#fetch(new URL(`v1/o/${object}`, server), headers);
    const firstByteSecs = this.#stream.now();
    const bytes = await bytesOf(answer, isWhole ? 200 : 206);
    if (bytes.length !== end - start) {
      throw new Error(`${bytes.length} bytes came, expected ${end - start}`);
    }
    const length = Number(answer.headers.get('Content-Length') ?? Number.NaN);
    const sent = answer.headers.has('Content-Encoding') && length > 0 ? length : bytes.length;
    this.#taken(() => client.answerBytes(id, bytes, sent, firstByteSecs, this.#stream.now()));
  }

  #fetch(url: URL, headers: Record<string, string>): Promise<Response> {
    // What is here is kept here; a conditional request is answered as it is.
    return fetch(url, { headers, cache: 'no-store', signal: this.#ended.signal });
  }

  /** Hands over an answer, unless the stream has ended; what is wrong with it no other try mends. */
  #taken(answer: () => void): void {
    if (this.#ended.signal.aborted) {
      return;
    }
    try {
      guarded(answer);
    } catch (error) {
      this.#stream.failed(error);
    }
  }

  #failed(id: number, error: unknown): void {
    if (this.#ended.signal.aborted) {
      return;
    }
    if (error instanceof ArticulaError) {
      this.#stream.failed(error);
      return;
    }
    this.#stream.lost(error instanceof Error ? error.message : String(error));
    this.#taken(() => this.#stream.client.answerNothing(id, this.#stream.now()));
    setTimeout(() => this.#next(), RETRY_MS);
  }

  #next(): void {
    if (!this.#ended.signal.aborted) {
      this.#stream.arrived();
      this.ask();
    }
  }
}

/** The body of an answer with a status. */
async function bytesOf(answer: Response, status: number): Promise<Uint8Array> {
  if (answer.status !== status) {
    throw new Error(await reason(answer));
  }
  return new Uint8Array(await answer.arrayBuffer());
}

/** Why a server refuses. */
async function reason(answer: Response): Promise<string> {
  const text = await answer.text();
  try {
    const { error } = JSON.parse(text) as { error?: unknown };
    return typeof error === 'string' ? error : `the server answers ${answer.status}`;
  } catch {
    return `the server answers ${answer.status}`;
  }
}
