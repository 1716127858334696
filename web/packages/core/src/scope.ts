/** The worker's end of a task. */
import { faultOf } from './error.js';
import type { Reply, Request, Task, TaskResult } from './messages.js';

/** The part of a worker's global scope that is used; the page's library of types has no other. */
interface Scope {
  onmessage: ((event: MessageEvent<Request>) => void) | null;
  postMessage(reply: Reply, transfer: Transferable[]): void;
}

/** Tells the page how far a task is. */
export type Report = (part: string, done: number, total: number) => boolean;

const scope = globalThis as unknown as Scope;

function send(reply: Reply, transfer: Transferable[] = []): void {
  scope.postMessage(reply, transfer);
}

const report: Report = (part, done, total) => {
  send({ progress: { part, done, total } });
  return true;
};

/** Loads a module and runs one task of the page, as soon as it comes. */
export function serve(
  load: (wasm: string | undefined) => Promise<unknown>,
  run: (task: Task, report: Report) => TaskResult<Task['call']>,
): void {
  scope.onmessage = ({ data }) => {
    load(data.wasm)
      .then(() => {
        const result = run(data.task, report);
        send({ result }, result instanceof Uint8Array ? [result.buffer as ArrayBuffer] : []);
      })
      .catch((error: unknown) => {
        const fault = faultOf(error);
        send(fault === undefined ? { failure: String(error) } : { fault });
      });
  };
}
