import {
  type ArrivedParts,
  ArticulaError,
  type CarriedFile,
  CharacterStream,
  type StreamContext,
  type StreamOptions,
  type StreamReport,
  type StreamState,
} from '@articula/core/stream';
import { type Camera, Object3D, type Object3DEventMap, Sphere, Vector3 } from 'three';

import { indexIn } from './asset.js';
import { AssetLook } from './asset-look.js';
import { PoseBounds } from './bounds.js';
import { FigureMesh, PaletteSkeleton } from './figure-mesh.js';
import { matrixOfRows } from './rows.js';

/** Events that a stream dispatches. */
export interface StreamEventMap extends Object3DEventMap {
  /** From `connecting` to `base`, the least that is shown, to `complete`, and back to `base` if more is asked for. */
  state: { readonly state: StreamState };
  /** Bytes have come. */
  progress: { readonly report: StreamReport };
  /** {@link ArticulaStream.mesh} shows a finer mesh or finer pictures: its geometry and materials are others. */
  refined: { readonly mesh: FigureMesh };
  /** The server is not reached; it is tried again. */
  lost: { readonly why: string };
  /** The stream has ended with an error; what is shown stays. */
  error: { readonly error: ArticulaError };
}

/** What is shown, and what of it is released when something finer replaces it. */
interface Shown {
  readonly parts: ArrivedParts;
  readonly look: AssetLook;
  readonly joints: readonly string[];
  readonly skeleton: PaletteSkeleton;
  readonly bounds: PoseBounds;
}

/** Distances that differ by less than this share are one to the server. */
const SAME_DISTANCE = 0.1;

const own = new Vector3();
const eye = new Vector3();

/**
 * A character of a server, as `articula serve` has them. The least that is shown comes first; finer motion, meshes and
 * textures take its place in the same {@link mesh} as their bytes arrive.
 */
export class ArticulaStream extends Object3D<StreamEventMap> {
  /** The mesh, once the base is here. It stays the same object. */
  mesh: FigureMesh | undefined;
  /** Resolves when the base is shown; rejects if that cannot be. */
  readonly ready: Promise<this>;
  #source: readonly [string | URL, string, StreamOptions];
  readonly #sockets = new Map<string, Object3D>();
  #stream: CharacterStream | undefined;
  #shown: Shown | undefined;
  #version = 0;
  #isMaking = false;
  #isEnded = false;
  #distance = 0;
  #state: StreamState = 'connecting';
  #wanted: readonly [string, number] | undefined;
  #context: StreamContext | undefined;
  #resolve: (stream: this) => void = () => undefined;
  #reject: (error: unknown) => void = () => undefined;

  /** Asks a server for a character by its name there. */
  constructor(server: string | URL, character: string, options: StreamOptions = {}) {
    super();
    this.name = character;
    this.#source = [server, character, options];
    this.ready = new Promise((resolve, reject) => {
      this.#resolve = resolve;
      this.#reject = reject;
    });
    // Who listens to `error` need not wait for this.
    this.ready.catch(() => undefined);
    const listener = {
      state: (state: StreamState) => this.#changed(state),
      progress: (report: StreamReport) => this.dispatchEvent({ type: 'progress', report }),
      lost: (why: string) => this.dispatchEvent({ type: 'lost', why }),
      error: (error: ArticulaError) => this.#failed(error),
    };
    CharacterStream.open(server, character, options, listener).then(
      (stream) => this.#opened(stream),
      (error: unknown) => this.#failed(error),
    );
  }

  get state(): StreamState {
    return this.#state;
  }

  /** Names of the clips, those too that have not come; empty before the server has told. */
  get clips(): readonly string[] {
    return this.#stream?.clips ?? [];
  }

  /** Name of the clip that plays; undefined before one does. */
  get clip(): string | undefined {
    return this.#stream?.clip;
  }

  /** Time within it in seconds. */
  get clipSecs(): number {
    return this.#stream?.clipSecs ?? 0;
  }

  /** Files that the character carries whole, such as sound and captions, those too that have not come. */
  get carried(): readonly CarriedFile[] {
    return this.#stream?.carried ?? [];
  }

  /** Bytes of a file that it carries; undefined until it has come. */
  carriedFile(file: string): Uint8Array | undefined {
    return this.#stream?.carriedFile(file);
  }

  /** What is shown, in numbers; undefined once the stream has ended. */
  get report(): StreamReport | undefined {
    return this.#stream?.report;
  }

  /** Plays a clip from `secs` on; what is missing of it is asked for. */
  play(clip: string, secs = 0): this {
    if (this.#stream === undefined) {
      this.#wanted = [clip, secs];
      return this;
    }
    const { clips } = this.#stream;
    if (clips.length > 0) {
      indexIn(clips, clip, 'clip', this.name);
    }
    this.#stream.play(clip, secs);
    return this;
  }

  /** Tells what has changed of network, device or viewer: all of it, as at first. */
  setContext(context: StreamContext): this {
    const [server, character, options] = this.#source;
    this.#source = [server, character, { ...options, context }];
    this.#context = context;
    this.#stream?.setContext(context);
    return this;
  }

  /** Returns an object that follows a joint: add to it what the character holds or wears. */
  socket(joint: string): Object3D {
    let socket = this.#sockets.get(joint);
    if (socket === undefined) {
      socket = new Object3D();
      socket.name = joint;
      socket.matrixAutoUpdate = false;
      this.#sockets.set(joint, socket);
      this.add(socket);
      this.#follow();
    }
    return socket;
  }

  /** Advances by `dtSecs` and shows what has come. With a camera, what it is too far to see is not asked for. */
  update(dtSecs: number, camera?: Camera): void {
    const stream = this.#stream;
    if (stream === undefined) {
      return;
    }
    if (camera !== undefined) {
      this.#see(stream, camera);
    }
    stream.frame(dtSecs);
    this.#renew();
    if (this.#shown !== undefined) {
      this.#pose(this.#shown);
    }
  }

  /** Returns another stream of the same character, where this one is. */
  override clone(): this {
    return new ArticulaStream(...this.#source).copy(this, false) as this;
  }

  /** Ends the stream, and releases what is shown. */
  override dispose(): void {
    super.dispose();
    this.removeFromParent();
    this.#end();
    if (this.mesh !== undefined) {
      this.remove(this.mesh);
    }
    if (this.#shown !== undefined) {
      release(this.#shown);
      this.#shown = undefined;
    }
    this.#reject(new ArticulaError({ code: 'cancelled', message: `${this.name}: disposed of`, file: this.name }));
  }

  #opened(stream: CharacterStream): void {
    if (this.#isEnded) {
      stream.dispose();
      return;
    }
    this.#stream = stream;
    if (this.#wanted !== undefined) {
      stream.play(...this.#wanted);
    }
    if (this.#context !== undefined) {
      stream.setContext(this.#context);
    }
  }

  #changed(state: StreamState): void {
    this.#state = state;
    this.dispatchEvent({ type: 'state', state });
    this.#renew();
  }

  #end(): void {
    this.#isEnded = true;
    this.#stream?.dispose();
    this.#stream = undefined;
  }

  #failed(reason: unknown): void {
    this.#end();
    const message = reason instanceof Error ? reason.message : String(reason);
    const error = reason instanceof ArticulaError ? reason : new ArticulaError({ code: 'invalid', message }, reason);
    this.#reject(error);
    this.dispatchEvent({ type: 'error', error });
  }

  /** Tells the distance where it has changed. */
  #see(stream: CharacterStream, camera: Camera): void {
    const distance = camera.getWorldPosition(eye).distanceTo(this.getWorldPosition(own));
    if (distance > 0 && Math.abs(distance - this.#distance) > SAME_DISTANCE * this.#distance) {
      this.#distance = distance;
      stream.setDistance(distance);
    }
  }

  /** Shows what has come, if it is finer: pictures are decoded first. */
  #renew(): void {
    const stream = this.#stream;
    if (stream === undefined || this.#isMaking || stream.version === this.#version) {
      return;
    }
    const { version } = stream;
    const parts = stream.arrived();
    if (parts === undefined) {
      return;
    }
    this.#isMaking = true;
    AssetLook.of(parts.asset)
      .then((look) => this.#show(parts, look))
      .catch((error: unknown) => this.#failed(error))
      .finally(() => {
        this.#isMaking = false;
        this.#version = version;
      });
  }

  #show(parts: ArrivedParts, look: AssetLook): void {
    const { geometry, ranges, bindings } = look.shape();
    const skeleton = new PaletteSkeleton(bindings);
    const bounds = new PoseBounds(geometry, bindings);
    const shown = { parts, look, joints: parts.asset.joints, skeleton, bounds };
    if (this.#isEnded) {
      release(shown);
      return;
    }
    const materials = ranges.map(({ material }) => look.material(material));
    const before = this.#shown;
    this.#shown = shown;
    if (this.mesh === undefined) {
      this.mesh = new FigureMesh(geometry, materials, skeleton);
      this.mesh.name = this.name;
      this.mesh.boundingSphere = new Sphere();
      this.add(this.mesh);
    } else {
      this.mesh.show(geometry, materials, skeleton);
    }
    this.#pose(shown);
    if (before !== undefined) {
      release(before);
    }
    this.dispatchEvent({ type: 'refined', mesh: this.mesh });
    this.#resolve(this);
  }

  #pose({ parts, look, skeleton, bounds }: Shown): void {
    const { mesh } = this;
    if (mesh === undefined) {
      return;
    }
    this.#stream?.pose(parts);
    skeleton.setPalette(parts.arrays.palette);
    mesh.castShadow = this.castShadow;
    mesh.receiveShadow = this.receiveShadow;
    const influences = mesh.morphTargetInfluences;
    if (influences !== undefined) {
      const weights = parts.arrays.morphs;
      look.shape().morphs.forEach((target, i) => {
        influences[i] = weights[target] ?? 0;
      });
    }
    this.#follow();
    bounds.enclose(mesh.boundingSphere as Sphere, (index, into) => skeleton.matrix(index, into));
  }

  /** Moves sockets to their joints. */
  #follow(): void {
    if (this.#shown === undefined || this.#sockets.size === 0) {
      return;
    }
    const { parts, joints } = this.#shown;
    const matrices = parts.arrays.joints;
    for (const [name, socket] of this.#sockets) {
      const joint = joints.indexOf(name);
      if (joint >= 0) {
        matrixOfRows(socket.matrix, matrices, joint);
        socket.matrix.decompose(socket.position, socket.quaternion, socket.scale);
        socket.matrixWorldNeedsUpdate = true;
      }
    }
  }
}

/** Releases what was shown. */
function release({ parts, look, skeleton }: Shown): void {
  look.dispose();
  skeleton.dispose();
  parts.arrival.free();
}
