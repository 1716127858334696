/** Runs one task of the tools in a worker, then ends. */
import init, { Tools } from '../wasm/tools.js';
import { serve } from './scope.js';

serve(
  (wasm) => init({ module_or_path: wasm ?? new URL('../wasm/tools_bg.wasm', import.meta.url) }),
  (task, report) => {
    const { bytes, name, options } = task;
    switch (task.call) {
      case 'prepare':
        return Tools.prepare(bytes, name, options, report);
      case 'convert':
        return Tools.convert(bytes, name, task.to, options, report);
      case 'addClips':
        return Tools.addClips(bytes, name, task.motion, task.motionName, options, report);
      case 'inspect':
        return Tools.inspect(bytes, name);
      default:
        throw new Error(`${task.call} is a task of the other worker`);
    }
  },
);
