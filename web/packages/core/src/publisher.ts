/** Runs one task of publishing in a worker, then ends. */
import init, { type MeasuredFile, type PackagedFile, Publisher } from '../wasm/publish.js';
import type { MeasuredBytes, PackagedBytes } from './messages.js';
import { serve } from './scope.js';

/** The file and its report, out of the module. */
function copied(made: MeasuredFile): MeasuredBytes {
  const copy = { bytes: made.bytes, report: made.report };
  made.free();
  return copy;
}

/** One of several files, out of the module. */
function copiedFile(file: PackagedFile): PackagedBytes {
  const copy = { name: file.name, bytes: file.bytes };
  file.free();
  return copy;
}

serve(
  (wasm) => init({ module_or_path: wasm ?? new URL('../wasm/publish_bg.wasm', import.meta.url) }),
  (task, report) => {
    const { bytes, name, options } = task;
    switch (task.call) {
      case 'flatten':
        return Publisher.flatten(bytes, name, options, report);
      case 'flattenMeasured':
        return copied(Publisher.flattenMeasured(bytes, name, options, report));
      case 'optimize':
        return copied(Publisher.optimize(bytes, name, options, report));
      case 'package':
        return Publisher.package(bytes, name, options, report).map(copiedFile);
      case 'portrait':
        return Publisher.portrait(bytes, name, options, report).map(copiedFile);
      case 'impostors':
        return Publisher.impostors(bytes, name, options, report).map(copiedFile);
      case 'encode':
        return Publisher.encode(bytes, name, options, report).map(copiedFile);
      case 'encodeFace':
        return Publisher.encodeFace(bytes, name, options, report).map(copiedFile);
      case 'addFaceClip':
        return Publisher.addFaceClip(bytes, name, task.motion, task.motionName, report);
      case 'addVoice':
        return Publisher.addVoice(bytes, name, task.voice, task.voiceName, report);
      case 'addRecording': {
        const { name: clip, times, joints, morphs } = task.recording;
        return Publisher.addRecording(bytes, name, clip, times, joints, morphs, report);
      }
      case 'benchmark':
        return Publisher.benchmark(bytes, name, options, report);
      case 'errorMatrix':
        return Publisher.errorMatrix(bytes, name, options, report);
      case 'evaluate':
        return Publisher.evaluate(bytes, name, options, report);
      default:
        throw new Error(`${task.call} is a task of the other worker`);
    }
  },
);
