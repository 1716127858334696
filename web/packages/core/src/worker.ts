/** Runs one task of the tools in a worker, then ends. */
import init, { Tools } from '../wasm/tools.js';
import { faultOf } from './error.js';
import type { PackagedBytes, Reply, Request, Task, TaskResult } from './messages.js';

/** The part of a worker's global scope that is used; the page's library of types has no other. */
interface Scope {
  onmessage: ((event: MessageEvent<Request>) => void) | null;
  postMessage(reply: Reply, transfer: Transferable[]): void;
}

const scope = globalThis as unknown as Scope;

function send(reply: Reply, transfer: Transferable[] = []): void {
  scope.postMessage(reply, transfer);
}

function run(task: Task): TaskResult<Task['call']> {
  const report = (part: string, done: number, total: number): boolean => {
    send({ progress: { part, done, total } });
    return true;
  };
  const { bytes, name, options } = task;
  switch (task.call) {
    case 'prepare':
      return Tools.prepare(bytes, name, options, report);
    case 'convert':
      return Tools.convert(bytes, name, task.to, options, report);
    case 'addClips':
      return Tools.addClips(bytes, name, task.motion, task.motionName, options, report);
    case 'flatten':
      return Tools.flatten(bytes, name, options, report);
    case 'inspect':
      return Tools.inspect(bytes, name);
    case 'package':
      return Tools.package(bytes, name, options, report).map((file): PackagedBytes => {
        const copy = { name: file.name, bytes: file.bytes };
        file.free();
        return copy;
      });
  }
}

scope.onmessage = ({ data }) => {
  init({ module_or_path: data.wasm ?? new URL('../wasm/tools_bg.wasm', import.meta.url) })
    .then(() => {
      const result = run(data.task);
      send({ result }, result instanceof Uint8Array ? [result.buffer as ArrayBuffer] : []);
    })
    .catch((error: unknown) => {
      const fault = faultOf(error);
      send(fault === undefined ? { failure: String(error) } : { fault });
    });
};
