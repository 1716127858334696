import { ArticulaError } from './error.js';
import type { ImpostorTable } from './impostors.js';
import type { PackagedBytes, Progress, Reply, Request, Task, TaskResult } from './messages.js';

/** How a task in a worker is watched and ended. */
export interface TaskOptions {
  readonly onProgress?: ((progress: Progress) => void) | undefined;
  /** Ends the task: it rejects with an {@link ArticulaError} of code `cancelled`. */
  readonly signal?: AbortSignal | undefined;
}

/** Options of {@link Tools.prepare}. */
export interface PrepareOptions extends TaskOptions {
  /**
   * Levels of the mesh to make, the finest included, 1 to 16; 1 makes none. If left out, the asset has those of the
   * file or, if it has none, those that crowds are shown with.
   */
  readonly meshLevels?: number | undefined;
}

/** Options of {@link Tools.convert}. */
export interface ConvertOptions extends TaskOptions {
  /** The one clip to keep. */
  readonly clip?: string | undefined;
  /** An expression of the joints that keep their motion, such as `loa(Low) + zone(hands)`; all keep it if left out. */
  readonly loa?: string | undefined;
  /** Pose of the other joints: that of the first frame, of rest, or of the frame nearest to the middle of the motion, `key-pose` if left out. */
  readonly passive?: 'hold' | 'rest' | 'key-pose' | undefined;
}

/** Options of {@link Tools.addClips}. */
export interface AddClipsOptions extends TaskOptions {
  /** The one clip of the motion to add. */
  readonly clip?: string | undefined;
  /** Whether the character keeps the clips that it has. */
  readonly keepOwn?: boolean | undefined;
  /** What the names of added clips begin with. */
  readonly prefix?: string | undefined;
}

/** Options of {@link Tools.flatten}. */
export interface FlattenOptions extends TaskOptions {
  /** An animated SVG, a JavaScript module or a Lottie file. */
  readonly form: 'svg' | 'player' | 'lottie';
  readonly clip?: string | undefined;
  readonly yawDeg?: number | undefined;
  readonly triangles?: number | undefined;
  readonly maxBytes?: number | undefined;
  /** A camera that stands where it is told to, in metres in the space of the character; one that frames it if left out. */
  readonly camera?: { readonly eye: Vector; readonly target: Vector; readonly fovDeg: number } | undefined;
}

type Vector = readonly [number, number, number];

/** What a figure showed, frame by frame. */
export interface RecordedFrames {
  /** Name of the clip that it becomes. */
  readonly name: string;
  /** Seconds of the frames, from 0 on. */
  readonly times: Float32Array;
  /** For each frame the matrix of each joint in model space, three rows of four numbers. */
  readonly joints: Float32Array;
  /** For each frame the weights of all morph targets. */
  readonly morphs: Float32Array;
}

/** Options of {@link Tools.portrait}. */
export interface PortraitOptions extends TaskOptions {
  /** The clip that it plays; the first if left out. */
  readonly clip?: string | undefined;
  readonly triangles?: number | undefined;
}

/** A head in 2D that turns and speaks. */
export interface PortraitFiles {
  /** A page of its own that shows it, HTML. */
  readonly page: Uint8Array;
  /** Its document, `portrait.json`, pictures and the script of its player. */
  readonly files: readonly PackagedBytes[];
  /** Sizes and errors of the page, as `articula flatten --json` tells them. */
  readonly report: unknown;
}

/** Options of {@link Tools.impostors}. */
export interface ImpostorOptions extends TaskOptions {
  /** The clips that they show; all if left out. */
  readonly clips?: readonly string[] | undefined;
  /** Most bytes of pixels, of four bytes each; 4 MiB if left out. */
  readonly maxBytes?: number | undefined;
  /** The lowest and the highest pitch of a camera above the horizon of the characters, degrees; any if left out. */
  readonly pitchesDeg?: readonly [number, number] | undefined;
  /** Whether the pictures have the colours of the character alone, for a material that is lit. */
  readonly unlit?: boolean | undefined;
}

/** Impostors: the table that crowds take, and the picture that has them, a PNG file. */
export interface ImpostorFiles {
  readonly table: ImpostorTable;
  readonly picture: Uint8Array;
}

/** Options of {@link Tools.encode} and {@link Tools.encodeFace}: those of a quantiser or of a tolerance. */
export interface EncodeOptions extends TaskOptions {
  /** The clip to encode; the first if left out. */
  readonly clip?: string | undefined;
  /** Quantiser of ABP-1 or AFP-1, 1 to 31; a tolerance counts if left out. */
  readonly quantizer?: number | undefined;
  /** Power of two by which the step of ABP-1 is further multiplied, 0 to 7. */
  readonly power?: number | undefined;
  /** Frames of ABP-1 between two coded ones that are left out, 0 to 31. */
  readonly interpolated?: number | undefined;
  /** Greatest error of ABP-2 in millimetres of skin, of AFP-2 of feature points; 0.1 if left out. */
  readonly toleranceMm?: number | undefined;
  /** Layers, of which leaving out the finest triples the error, 1 to 8. */
  readonly tiers?: number | undefined;
  /** What joints have in common that are cut together. */
  readonly groupBy?: 'loa' | 'region' | 'joint' | undefined;
}

/** A file, with sizes, errors and settings as the command of the program tells them with `--json`. */
export interface MeasuredFile {
  readonly bytes: Uint8Array;
  readonly report: unknown;
}

/** Options of {@link Tools.optimize}. */
export interface OptimizeOptions extends TaskOptions {
  /** Greatest error in motion, in pixels of a picture of 720 lines that the figure at rest fills; 1 if left out. */
  readonly errorPx?: number | undefined;
  /** The same in millimetres, in place of pixels. */
  readonly errorMm?: number | undefined;
  /** Extension of compressed arrays: `ext`, which viewers and engines read, `khr`, of fewer bytes; or none with integers, `quantize`, or `none`. */
  readonly compress?: 'ext' | 'khr' | 'quantize' | 'none' | undefined;
  /** Whether all keys stay. */
  readonly keepKeys?: boolean | undefined;
  /** Whether all triangles stay. */
  readonly keepTriangles?: boolean | undefined;
  /** Whether pictures stay as they are. */
  readonly keepTextures?: boolean | undefined;
  /** Whether attributes stay that no material uses. */
  readonly keepAttributes?: boolean | undefined;
}

/** Options of {@link Tools.benchmark}. */
export interface BenchmarkOptions extends TaskOptions {
  /** One walking figure, drawn; a face, drawn; or many figures, posed. `body` if left out. */
  readonly application?: 'body' | 'face' | 'crowd' | undefined;
  /** Most seconds of frames; 10 if left out. */
  readonly seconds?: number | undefined;
  /** Grades to play, 0 the finest to 11; those around 25 and 60 frames a second if left out. */
  readonly grades?: readonly number[] | undefined;
}

/** Options of {@link Tools.evaluate}. */
export interface EvaluateOptions extends TaskOptions {
  /** The clip to play; the first if left out. */
  readonly clip?: string | undefined;
  /** A method of `articula lod`, or `all`; `skin-px` if left out. */
  readonly method?: string | undefined;
  /** An expression of the joints that move, in place of a method. */
  readonly loa?: string | undefined;
  /** Distances of the camera in metres. */
  readonly distances?: readonly number[] | undefined;
  /** Finds the parameter that saves the most at an error of so many pixels. */
  readonly calibratePx?: number | undefined;
  /** Weight of orientation against angular velocity in the method `thesis`, 0 to 1; 0.5 if left out. */
  readonly beta?: number | undefined;
}

/** Options of {@link Tools.errorMatrix}. */
export interface ErrorMatrixOptions extends TaskOptions {
  /** The clip; the first if left out. */
  readonly clip?: string | undefined;
  /** Weight of orientation against angular velocity, 0 to 1; 0.5, as files store it, if left out. */
  readonly beta?: number | undefined;
}

/** Options of {@link Tools.package}. */
export interface PackageOptions extends TaskOptions {
  readonly meshLevels?: number | undefined;
  readonly clips?: readonly string[] | undefined;
  readonly flat?: boolean | undefined;
}

/** Where the workers and their modules are; found beside this script if left out. */
export interface ToolsSource {
  /** The worker that prepares and converts, and its module. */
  readonly worker?: (() => Worker) | undefined;
  readonly wasm?: string | URL | undefined;
  /** The worker that makes 2D pictures, items, lighter files, motions of faces and voices, and evaluates; its module. */
  readonly publisher?: (() => Worker) | undefined;
  readonly publishWasm?: string | URL | undefined;
}

/** Names of the page of a portrait and of the report about it among its files. */
const PORTRAIT_PAGE = 'portrait.html';
const PORTRAIT_REPORT = 'report.json';
const IMPOSTOR_TABLE = 'impostors.json';

/** Files that the publisher opens. Others are converted first. */
const IS_PUBLISHED = /\.(glb|vrm)$/i;

/** What the publisher does. */
const PUBLISHES: ReadonlySet<Task['call']> = new Set(['flatten', 'flattenMeasured', 'package', 'addFaceClip', 'addVoice', 'addRecording', 'evaluate', 'errorMatrix', 'optimize', 'benchmark', 'portrait', 'impostors', 'encode', 'encodeFace']);

/** Functions that take seconds. Each call runs in a worker of its own, on a copy of the bytes. */
export class Tools {
  readonly #source: ToolsSource;

  constructor(source: ToolsSource = {}) {
    this.#source = source;
  }

  /** Returns the file with all tables that playing it needs: it then opens at once. */
  prepare(bytes: Uint8Array, name: string, options: PrepareOptions = {}): Promise<Uint8Array> {
    return this.#run({ call: 'prepare', bytes, name, ...split(options) });
  }

  /** Returns a character or motion as a file with the extension `to`. */
  convert(bytes: Uint8Array, name: string, to: string, options: ConvertOptions = {}): Promise<Uint8Array> {
    return this.#run({ call: 'convert', bytes, name, to, ...split(options) });
  }

  /** Returns the character with the clips of a motion file, retargeted. */
  addClips(
    bytes: Uint8Array,
    name: string,
    motion: Uint8Array,
    motionName: string,
    options: AddClipsOptions = {},
  ): Promise<Uint8Array> {
    return this.#run({ call: 'addClips', bytes, name, motion, motionName, ...split(options) });
  }

  /** Returns the character with the motion of a face: a FAP, AFP or FBA file, or a capture of Live Link Face (CSV). */
  async addFaceClip(
    bytes: Uint8Array,
    name: string,
    motion: Uint8Array,
    motionName: string,
    options: TaskOptions = {},
  ): Promise<Uint8Array> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'addFaceClip', ...file, motion, motionName, ...split(options) });
  }

  /** Returns the character with a clip of its face that speaks a recording, a WAV file of one voice. */
  async addVoice(
    bytes: Uint8Array,
    name: string,
    voice: Uint8Array,
    voiceName: string,
    options: TaskOptions = {},
  ): Promise<Uint8Array> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'addVoice', ...file, voice, voiceName, ...split(options) });
  }

  /** Returns the character with what a figure of it showed as a clip, in place of one of the same name. */
  async addRecording(bytes: Uint8Array, name: string, recording: RecordedFrames, options: TaskOptions = {}): Promise<Uint8Array> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'addRecording', ...file, recording, ...split(options) });
  }

  /** Returns a clip as a moving picture of 2D shapes. */
  async flatten(bytes: Uint8Array, name: string, options: FlattenOptions): Promise<Uint8Array> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'flatten', ...file, ...split(options) });
  }

  /** Returns a clip as a moving picture of 2D shapes, and measures it. */
  async flattenMeasured(bytes: Uint8Array, name: string, options: FlattenOptions): Promise<MeasuredFile> {
    const file = await this.#published(bytes, name, options);
    const made = await this.#run({ call: 'flattenMeasured', ...file, ...split(options) });
    return { bytes: made.bytes, report: JSON.parse(made.report) };
  }

  /** Returns the head of a character as a portrait, a page and what is in it, and measures it. */
  async portrait(bytes: Uint8Array, name: string, options: PortraitOptions = {}): Promise<PortraitFiles> {
    const file = await this.#published(bytes, name, options);
    const made = await this.#run({ call: 'portrait', ...file, ...split(options) });
    const find = (wanted: string): Uint8Array => made.find((part) => part.name === wanted)?.bytes ?? new Uint8Array();
    return {
      page: find(PORTRAIT_PAGE),
      files: made.filter((part) => part.name !== PORTRAIT_PAGE && part.name !== PORTRAIT_REPORT),
      report: JSON.parse(new TextDecoder().decode(find(PORTRAIT_REPORT))),
    };
  }

  /** Returns pictures of a character for who is far away, as `CrowdOptions.impostors` takes them. */
  async impostors(bytes: Uint8Array, name: string, options: ImpostorOptions = {}): Promise<ImpostorFiles> {
    const file = await this.#published(bytes, name, options);
    const made = await this.#run({ call: 'impostors', ...file, ...split(options) });
    const table = made.find((part) => part.name === IMPOSTOR_TABLE)?.bytes;
    const picture = made.find((part) => part.name !== IMPOSTOR_TABLE)?.bytes;
    return {
      table: JSON.parse(new TextDecoder().decode(table)) as ImpostorTable,
      picture: picture ?? new Uint8Array(),
    };
  }

  /** Returns the error of each joint at each key of a clip, as `Figure.setErrors` takes it. */
  async errorMatrix(bytes: Uint8Array, name: string, options: ErrorMatrixOptions = {}): Promise<Float32Array> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'errorMatrix', ...file, ...split(options) });
  }

  /** Returns a clip as a stream (.abp), its description (.gbsd.xml) and, of layers within a tolerance, aqos.xml. */
  async encode(bytes: Uint8Array, name: string, options: EncodeOptions = {}): Promise<PackagedBytes[]> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'encode', ...file, ...split(options) });
  }

  /** Returns facial animation parameters (.fap, .afp, .fba) as a stream (.afp) and its description (.gbsd.xml). */
  encodeFace(bytes: Uint8Array, name: string, options: EncodeOptions = {}): Promise<PackagedBytes[]> {
    return this.#run({ call: 'encodeFace', bytes, name, ...split(options) });
  }

  /** Returns the character as a GLB in fewer bytes, and what that costs and saves, as `articula optimize --json` tells it. */
  async optimize(bytes: Uint8Array, name: string, options: OptimizeOptions = {}): Promise<MeasuredFile> {
    const file = await this.#published(bytes, name, options);
    const made = await this.#run({ call: 'optimize', ...file, ...split(options) });
    return { bytes: made.bytes, report: JSON.parse(made.report) };
  }

  /** Returns what methods of motion level of detail save and show, as `articula lod --json` tells it. */
  async evaluate(bytes: Uint8Array, name: string, options: EvaluateOptions = {}): Promise<unknown> {
    const file = await this.#published(bytes, name, options);
    return JSON.parse(await this.#run({ call: 'evaluate', ...file, ...split(options) }));
  }

  /** Returns what this device can play of a character, as `articula bench device --json` tells it, beside the reference. */
  async benchmark(bytes: Uint8Array, name: string, options: BenchmarkOptions = {}): Promise<unknown> {
    const file = await this.#published(bytes, name, options);
    return JSON.parse(await this.#run({ call: 'benchmark', ...file, ...split(options) }));
  }

  /** Returns what is in a file: joints, clips, meshes, face, warnings. */
  async inspect(bytes: Uint8Array, name: string, options: TaskOptions = {}): Promise<unknown> {
    return JSON.parse(await this.#run({ call: 'inspect', bytes, name, ...split(options) }));
  }

  /** Returns the files of a digital item, from which a server sends parts. */
  async package(bytes: Uint8Array, name: string, options: PackageOptions = {}): Promise<PackagedBytes[]> {
    const file = await this.#published(bytes, name, options);
    return this.#run({ call: 'package', ...file, ...split(options) });
  }

  /** A file as the publisher opens it. */
  async #published(bytes: Uint8Array, name: string, { signal }: TaskOptions): Promise<{ bytes: Uint8Array; name: string }> {
    if (IS_PUBLISHED.test(name)) {
      return { bytes, name };
    }
    return { bytes: await this.convert(bytes, name, 'glb', { signal }), name: `${name}.glb` };
  }

  #run<T extends Task>({ watch, ...rest }: T & { watch: TaskOptions }): Promise<TaskResult<T['call']>> {
    const task = rest as unknown as Task;
    const { onProgress, signal } = watch;
    const cancelled = (): ArticulaError =>
      new ArticulaError({ code: 'cancelled', message: `${task.name}: cancelled`, file: task.name });
    if (signal?.aborted) {
      return Promise.reject(cancelled());
    }
    const { worker, wasm } = this.#start(task.call);
    const abort = new AbortController();
    return new Promise<TaskResult<T['call']>>((resolve, reject) => {
      signal?.addEventListener('abort', () => reject(cancelled()), { signal: abort.signal });
      worker.onmessage = ({ data }: MessageEvent<Reply>) => {
        if ('progress' in data) {
          onProgress?.(data.progress);
        } else if ('result' in data) {
          resolve(data.result as TaskResult<T['call']>);
        } else if ('fault' in data) {
          reject(new ArticulaError(data.fault));
        } else {
          reject(new Error(data.failure));
        }
      };
      worker.onerror = ({ message }) => reject(new Error(`the worker failed: ${message || 'its script is not there'}`));
      const request: Request = { task, wasm: wasm?.toString() };
      worker.postMessage(request);
    }).finally(() => {
      abort.abort();
      worker.terminate();
    });
  }

  /** Starts the worker that has a call; bundlers find its script by these very words. */
  #start(call: Task['call']): { worker: Worker; wasm: string | URL | undefined } {
    const { worker, wasm, publisher, publishWasm } = this.#source;
    if (PUBLISHES.has(call)) {
      const started = publisher?.() ?? new Worker(new URL('./publisher.js', import.meta.url), { type: 'module' });
      return { worker: started, wasm: publishWasm };
    }
    const started = worker?.() ?? new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    return { worker: started, wasm };
  }
}

/** Returns options as JSON, and how the task is watched. */
function split({ onProgress, signal, ...options }: TaskOptions): { options: string; watch: TaskOptions } {
  return { options: JSON.stringify(options), watch: { onProgress, signal } };
}
