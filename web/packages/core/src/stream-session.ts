import { guarded } from './error.js';
import type { LinkedStream, StreamLink } from './stream-link.js';

/** Pause before a lost session begins again, milliseconds. */
const PAUSE_MS = 500;

/** A session over a WebSocket: the server decides what comes. */
export class SessionLink implements StreamLink {
  readonly #stream: LinkedStream;
  #socket: WebSocket | undefined;
  #again: ReturnType<typeof setTimeout> | undefined;
  #isClosed = false;

  constructor(stream: LinkedStream) {
    this.#stream = stream;
    this.#connect();
  }

  ask(): void {
    if (this.#socket?.readyState === WebSocket.OPEN) {
      this.#send(this.#socket, this.#stream.client.update(this.#stream.now()));
    }
  }

  close(): void {
    this.#isClosed = true;
    clearTimeout(this.#again);
    this.#socket?.close();
  }

  #connect(): void {
    const url = new URL('v1/session', this.#stream.server);
    url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
    const socket = new WebSocket(url);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => this.#send(socket, this.#stream.client.hello(this.#stream.now()));
    socket.onmessage = ({ data }: MessageEvent<unknown>) => this.#take(socket, data);
    socket.onclose = () => this.#lost();
    this.#socket = socket;
  }

  #take(socket: WebSocket, data: unknown): void {
    if (this.#isClosed || !(data instanceof ArrayBuffer)) {
      return;
    }
    try {
      this.#send(socket, guarded(() => this.#stream.client.take(new Uint8Array(data), this.#stream.now())));
      this.#stream.arrived();
    } catch (error) {
      this.#stream.failed(error);
    }
  }

  #send(socket: WebSocket, message: Uint8Array | undefined): void {
    if (message !== undefined) {
      socket.send(message as Uint8Array<ArrayBuffer>);
    }
  }

  #lost(): void {
    if (!this.#isClosed) {
      this.#stream.lost('the session ended');
      this.#again = setTimeout(() => this.#connect(), PAUSE_MS);
    }
  }
}
