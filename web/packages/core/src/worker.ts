/** Runs one task of the tools in a worker, then ends. */
import init, { Tools } from '../wasm/tools.js';
import { faultOf } from './error.js';
import type { Reply, Request, Task } from './messages.js';

/** The part of a worker's global scope that is used; the page's library of types has no other. */
interface Scope {
  onmessage: ((event: MessageEvent<Request>) => void) | null;
  postMessage(reply: Reply, transfer: Transferable[]): void;
}

const scope = globalThis as unknown as Scope;

function send(reply: Reply, transfer: Transferable[] = []): void {
  scope.postMessage(reply, transfer);
}

function run(task: Task): Uint8Array {
  const report = (part: string, done: number, total: number): boolean => {
    send({ progress: { part, done, total } });
    return true;
  };
  switch (task.call) {
    case 'prepare':
      return Tools.prepare(task.bytes, task.name, task.options, report);
    case 'convert':
      return Tools.convert(task.bytes, task.name, task.to, task.options, report);
    case 'addClips':
      return Tools.addClips(task.bytes, task.name, task.motion, task.motionName, task.options, report);
    case 'flatten':
      return Tools.flatten(task.bytes, task.name, task.options, report);
  }
}

scope.onmessage = ({ data }) => {
  init({ module_or_path: data.wasm ?? new URL('../wasm/tools_bg.wasm', import.meta.url) })
    .then(() => {
      const result = run(data.task);
      send({ result }, [result.buffer as ArrayBuffer]);
    })
    .catch((error: unknown) => {
      const fault = faultOf(error);
      send(fault === undefined ? { failure: String(error) } : { fault });
    });
};
