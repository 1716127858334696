import { Articula, type RecordedFrames } from '@articula/core';
import { ArticulaAsset } from '@articula/three';

import { baseOf, isItem, kindOf, refused } from './files.js';
import { KeptTools } from './kept-tools.js';
import { readState, type StudioState, writeState } from './state.js';
import { hasCharacters, put } from './stream/server.js';
import type { Notices, TaskLine } from './ui/status.js';
import { type CameraKey, readCameraPath, type RecordedCamera } from './view/camera-path.js';

/** The character of the page: its file as bytes, and opened. */
export interface Character {
  readonly asset: ArticulaAsset;
  readonly bytes: Uint8Array;
  readonly name: string;
}

/** A file as it was given. */
export interface SourceFile {
  readonly bytes: Uint8Array;
  readonly name: string;
}

/** Milliseconds from the last change to the permalink. */
const LINK_MS = 250;

/** What all pages share: the state of the permalink, the module, and the character. */
export class Studio extends EventTarget {
  state: StudioState = readState(location.hash);
  readonly articula: Articula;
  readonly task: TaskLine;
  readonly notices: Notices;
  readonly tools: KeptTools;
  character: Character;
  /** The file of the character as it was given, before anything was made of it. */
  source: SourceFile;
  /** The path of a camera that was recorded or opened; empty without. */
  cameraPath: readonly CameraKey[] = [];
  /** Recordings that clips speak, as WAV files, by the names of the clips. */
  readonly voices = new Map<string, Uint8Array>();
  /** Cameras that clips were recorded by, by the names of the clips. */
  readonly cameras = new Map<string, RecordedCamera>();
  #link = 0;

  private constructor(articula: Articula, character: Character, task: TaskLine, notices: Notices, tools: KeptTools) {
    super();
    this.articula = articula;
    this.character = character;
    this.source = character;
    this.task = task;
    this.notices = notices;
    this.tools = tools;
    if (matchMedia('(prefers-reduced-motion: reduce)').matches && !location.hash.includes('playing=')) {
      this.state.playing = false;
    }
  }

  /** Loads the module and the character that the page begins with. */
  static async start(task: TaskLine, notices: Notices): Promise<Studio> {
    const tools = new KeptTools();
    const loading = Articula.load({ tools: tools.source });
    const [articula, bytes] = await Promise.all([loading, fetchBytes('./human.glb')]);
    return new Studio(articula, await opened(articula, bytes, 'human.glb'), task, notices, tools);
  }

  /** Changes the state, and the permalink a moment later. */
  set(change: Partial<StudioState>): void {
    Object.assign(this.state, change);
    this.dispatchEvent(new Event('state'));
    clearTimeout(this.#link);
    this.#link = window.setTimeout(() => history.replaceState(null, '', writeState(this.state)), LINK_MS);
  }

  /** The address that shows what is shown now. */
  permalink(): string {
    return new URL(writeState(this.state), location.href).href;
  }

  /** Opens a file of the visitor: a character in place of this one, or a motion or a profile for it. */
  async open(file: File): Promise<void> {
    try {
      const kind = kindOf(file.name);
      if (kind === 'unknown') {
        throw refused(file.name);
      }
      const bytes = new Uint8Array(await file.arrayBuffer());
      switch (kind) {
        case 'json':
          this.#takeJson(new TextDecoder().decode(bytes), file.name);
          break;
        case 'item':
          await this.#offerItem(bytes, file.name);
          break;
        case 'motion':
        case 'face':
        case 'voice':
          await this.#addMotion(bytes, file.name);
          break;
        default:
          await this.#openCharacter(bytes, file.name);
      }
    } catch (error) {
      this.notices.fault(error);
    }
  }

  /** The file with all tables, made once. */
  async prepared(): Promise<Character> {
    if (!this.character.asset.core.isPrepared) {
      await this.#prepare(this.character.bytes, this.character.name);
    }
    return this.character;
  }

  /** Adds what was shown as a clip, which is seen as it was by the camera with which it began. */
  async addRecording(recording: RecordedFrames, camera: RecordedCamera): Promise<void> {
    const { character } = this;
    const { name } = recording;
    const made = await this.task.run(`Adding ${name}`, (watch) => this.articula.tools.addRecording(character.bytes, character.name, recording, watch));
    this.cameras.set(name, camera);
    Object.assign(this.state, { clip: name, camera: camera.pose, at: 0 });
    this.source = { bytes: made, name: character.name };
    this.#show(await opened(this.articula, made, character.name));
    this.notices.say(`${name} is a clip of ${character.name}: Flat makes a picture of it.`);
    await this.#prepare(made, character.name);
  }

  async #openCharacter(bytes: Uint8Array, name: string): Promise<void> {
    // What is still made of the file before must not come after this one.
    this.task.cancel();
    this.source = { bytes, name };
    this.state.camera = '';
    const isPlayed = kindOf(name) === 'played';
    this.voices.clear();
    this.cameras.clear();
    if (isPlayed) {
      // It plays at once, and with its tables when they are there.
      this.#show(await opened(this.articula, bytes, name));
      if (this.character.asset.core.isPrepared) {
        return;
      }
      this.notices.say(`${name} plays. Its tables for pixel errors and crowds are made meanwhile.`);
    }
    if (!isPlayed) {
      const found = await this.task.run(`Reading ${name}`, (watch) => this.articula.tools.inspect(bytes, name, watch));
      if ((found as { meshes: unknown[] }).meshes.length === 0) {
        await this.#addMotion(bytes, name);
        return;
      }
    }
    await this.#prepare(bytes, name);
  }

  async #prepare(bytes: Uint8Array, name: string): Promise<void> {
    const glb = await this.task.run(`Preparing ${name}`, (watch) => this.articula.tools.prepare(bytes, name, watch));
    this.#show(await opened(this.articula, glb, kindOf(name) === 'played' ? name : `${name}.glb`));
  }

  async #addMotion(bytes: Uint8Array, name: string): Promise<void> {
    const { character } = this;
    const { tools } = this.articula;
    const kind = kindOf(name);
    const moved = await this.task.run(`Adding ${name}`, (watch) => {
      const file = [character.bytes, character.name, bytes, name] as const;
      return kind === 'voice' ? tools.addVoice(...file, watch) : kind === 'face' ? tools.addFaceClip(...file, watch) : tools.addClips(...file, { keepOwn: true, ...watch });
    });
    const before = new Set(character.asset.clips);
    const next = await opened(this.articula, moved, character.name);
    const added = next.asset.clips.find((clip) => !before.has(clip)) ?? next.asset.clips.at(-1);
    this.state.clip = added ?? '';
    if (kind === 'voice') {
      this.voices.set(this.state.clip, bytes);
    }
    this.#show(next);
    this.notices.say(kind === 'voice' ? `${character.name} speaks ${name}.` : `${name} now moves ${character.name}.`);
    this.source = { bytes: moved, name: character.name };
    await this.#prepare(moved, character.name);
  }

  /** Says what is done with a digital item: servers show them, and this one may be given it. */
  async #offerItem(bytes: Uint8Array, name: string): Promise<void> {
    if (!isItem(bytes)) {
      throw new Error(`${name}: a ZIP file without a manifest.json is no digital item. articula package makes one; take other files out of it.`);
    }
    if (!(await hasCharacters())) {
      this.notices.stay(`${name} is a digital item, which a server shows while it arrives: put it in a folder, run articula serve FOLDER, and open the page Stream there.`);
      return;
    }
    this.notices.stay(`${name} is a digital item. Stream shows it once this server has it.`, {
      label: 'Send it to the server',
      act: () => this.#sendItem(bytes, baseOf(name)).catch((error: unknown) => this.notices.fault(error)),
    });
  }

  async #sendItem(bytes: Uint8Array, name: string): Promise<void> {
    const character = name.replaceAll(/[^\w.-]/g, '-').replace(/^\./, '');
    await this.task.run(`Sending ${name}`, () => put(character, bytes));
    this.set({ character, clip: '', page: 'stream' });
    this.dispatchEvent(new Event('page'));
  }

  /** Takes over a camera path, which is a list, or a LoA profile. */
  #takeJson(text: string, name: string): void {
    if (!text.trimStart().startsWith('[')) {
      this.#takeProfile(text);
      return;
    }
    try {
      this.cameraPath = readCameraPath(text);
    } catch (error) {
      throw new Error(`${name}: ${error instanceof Error ? error.message : String(error)}`);
    }
    this.set({ page: 'stage' });
    this.dispatchEvent(new Event('camera-path'));
    this.dispatchEvent(new Event('page'));
    this.notices.say(`Stage replays ${name}: Camera path, Replay.`);
  }

  /** Takes over a LoA profile. */
  #takeProfile(text: string): void {
    this.character.asset.core.jointsOfProfile(text);
    const profile = JSON.parse(text) as Record<string, unknown> & { joints?: { plus?: string[]; minus?: string[] } };
    this.set({
      expression: '',
      complexity: String(profile.complexity ?? ''),
      depth: Number(profile.depth ?? 0),
      hanim: String(profile.hanim ?? ''),
      zones: ((profile.zones as string[] | undefined) ?? []).join(','),
      rule: profile.rule === 'restrict' ? 'restrict' : 'sum',
      plus: (profile.joints?.plus ?? []).join(','),
      minus: (profile.joints?.minus ?? []).join(','),
    });
    this.dispatchEvent(new Event('character'));
  }

  #show(character: Character): void {
    const before = this.character;
    this.character = character;
    this.dispatchEvent(new Event('character'));
    before.asset.dispose();
  }
}

/** Index of the clip that the state names; the first if the character has none of that name. */
export function chosenClip(studio: Studio): number {
  return Math.max(studio.character.asset.clips.indexOf(studio.state.clip), 0);
}

/** A time within the clip that the state names, which plays again and again. */
export function loopedSecs(studio: Studio, secs: number): number {
  const length = studio.character.asset.clipSecs[chosenClip(studio)] ?? 1;
  return secs % Math.max(length, 1e-3);
}

async function opened(articula: Articula, bytes: Uint8Array, name: string): Promise<Character> {
  return { asset: await ArticulaAsset.of(articula, articula.open(bytes, name)), bytes, name };
}

async function fetchBytes(url: string): Promise<Uint8Array> {
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${url}: the server answers ${response.status}`);
  }
  return new Uint8Array(await response.arrayBuffer());
}
