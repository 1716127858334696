import type { Client } from '../wasm/stream.js';

/** A way to a server: what the client asks for goes out, what comes goes to the client. */
export interface StreamLink {
  /** Asks for what the client lacks now. */
  ask(): void;
  /** Ends all that is under way. */
  close(): void;
}

/** What a link has of its stream. */
export interface LinkedStream {
  readonly client: Client;
  /** Address of the server, with a slash at its end. */
  readonly server: URL;
  /** Seconds on the clock of the client. */
  now(): number;
  /** Something has come. */
  arrived(): void;
  /** The connection is lost, and tried again. */
  lost(why: string): void;
  /** What no other try mends. */
  failed(error: unknown): void;
}
