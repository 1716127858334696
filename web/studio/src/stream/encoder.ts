import type { EncodeOptions, PackagedBytes } from '@articula/core';

import { baseOf } from '../files.js';
import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';
import { button, choice, section, segmented, slider } from '../ui/controls.js';
import { download, h, inBytes } from '../ui/dom.js';
import { TaskLine } from '../ui/status.js';

/** Motions that hold facial animation parameters. */
const FACES = '.fap,.afp,.fba';
/** Name of the table. */
const TABLE = 'aqos.xml';
/** Most and least exponent of ten of a tolerance in millimetres. */
const TOLERANCES = [-2, 1] as const;

/** Encodes a clip of the character, or parameters of a face, as a stream that can be cut, with the documents by which it is. */
export class EncoderPanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #task = new TaskLine();
  readonly #clip: ReturnType<typeof choice>;
  readonly #layered: HTMLElement;
  readonly #quantised: HTMLElement;
  readonly #files = h('div', { class: 'buttons', role: 'group', 'aria-label': 'Files of the encoder' });
  readonly #said = h('p', { class: 'said', role: 'status' });

  constructor(studio: Studio) {
    this.#studio = studio;
    const { state } = studio;
    const set = (change: Partial<StudioState>): void => studio.set(change);
    this.#clip = choice('Clip to encode', [], '', (clip) => set({ clip }));
    const coding = segmented('Coding', [['tolerance', 'Within an error'], ['quantizer', 'Quantised']], state.coding, (word) => {
      set({ coding: word as StudioState['coding'] });
      this.#suit();
    });
    const exact = slider({ label: 'Error of the finest layer', min: TOLERANCES[0], max: TOLERANCES[1], step: 0.05, value: Math.log10(state.mm), shown: (power) => `${rounded(10 ** power)} mm`, onInput: (power) => set({ mm: rounded(10 ** power) }) });
    const layers = slider({ label: 'Layers', min: 1, max: 8, step: 1, value: state.layers, shown: String, hint: 'Without the finest one the error is three times as large.', onInput: (n) => set({ layers: n }) });
    const group = choice('Cut together', [['region', 'Level and region'], ['loa', 'Level'], ['joint', 'Joint']], state.cut, (word) => set({ cut: word as StudioState['cut'] }));
    const quantizer = slider({ label: 'Quantiser', min: 1, max: 31, step: 1, value: state.quantizer, shown: String, onInput: (n) => set({ quantizer: n }) });
    const power = slider({ label: 'Step times', min: 0, max: 7, step: 1, value: state.power, shown: (n) => `${2 ** n}`, onInput: (n) => set({ power: n }) });
    const skipped = slider({ label: 'Frames left out between two', min: 0, max: 31, step: 1, value: state.skipped, shown: (n) => (n === 0 ? 'none' : `${n}`), hint: 'Readers interpolate them. Faces have the quantiser alone.', onInput: (n) => set({ skipped: n }) });
    this.#layered = h('div', { class: 'stack' }, exact.element, layers.element, group.element);
    this.#quantised = h('div', { class: 'stack' }, quantizer.element, power.element, skipped.element);
    const picker = h('input', { type: 'file', accept: FACES, hidden: true, 'aria-label': 'Facial animation parameters' });
    picker.addEventListener('change', () => {
      const file = picker.files?.[0];
      if (file !== undefined) {
        void this.#encodeFace(file);
      }
      picker.value = '';
    });
    const run = h('div', { class: 'buttons' }, button('Encode the clip', () => void this.#encodeClip(), 'primary'), button('Encode a FAP file', () => picker.click()), picker);
    const hint = h('p', { class: 'hint' }, 'Streams of bodies (.abp) and faces (.afp), their descriptions after MPEG-21 (gBSD), and of bodies within an error the table of what is sent at which rate (AQoS). All is made on this machine, from the character that is opened.');
    this.element = section('Encoder', false, this.#clip.element, coding.element, this.#layered, this.#quantised, run, this.#task.element, this.#said, this.#files, hint);
    this.#suit();
    studio.addEventListener('character', () => this.renew());
  }

  /** Takes over the clips of the character. */
  renew(): void {
    const { asset } = this.#studio.character;
    this.#clip.fill(asset.clips.map((name) => [name, name] as const));
    if (asset.clips.includes(this.#studio.state.clip)) {
      this.#clip.set(this.#studio.state.clip);
    }
  }

  #suit(): void {
    const isLayered = this.#studio.state.coding === 'tolerance';
    this.#layered.hidden = !isLayered;
    this.#quantised.hidden = isLayered;
  }

  /** What both encoders have in common. */
  #options(): EncodeOptions {
    const { coding, mm, layers, quantizer } = this.#studio.state;
    return coding === 'tolerance' ? { toleranceMm: mm, tiers: layers } : { quantizer };
  }

  async #encodeClip(): Promise<void> {
    const { articula, character, state } = this.#studio;
    const { coding, cut, power, skipped } = state;
    const clip = character.asset.clips.includes(state.clip) ? state.clip : character.asset.clips[0];
    const more = coding === 'tolerance' ? { groupBy: cut } : { power, interpolated: skipped };
    await this.#show(`Encoding ${clip ?? 'the clip'}`, (watch) => articula.tools.encode(character.bytes, character.name, { ...(clip !== undefined && { clip }), ...this.#options(), ...more, ...watch }));
  }

  async #encodeFace(file: File): Promise<void> {
    const bytes = new Uint8Array(await file.arrayBuffer());
    await this.#show(`Encoding ${file.name}`, (watch) => this.#studio.articula.tools.encodeFace(bytes, file.name, { ...this.#options(), ...watch }));
  }

  /** Encodes, and offers the files. */
  async #show(what: string, encode: (watch: Parameters<Parameters<TaskLine['run']>[1]>[0]) => Promise<readonly PackagedBytes[]>): Promise<void> {
    try {
      const files = await this.#task.run(what, encode);
      const [stream] = files;
      this.#said.textContent = stream === undefined ? '' : `${stream.name}: ${inBytes(stream.bytes.length)}`;
      this.#files.replaceChildren(...files.map((file) => button(`Save ${kindOf(file.name)}`, () => this.#save(file), 'small')));
    } catch (error) {
      this.#studio.notices.fault(error);
    }
  }

  #save({ name, bytes }: PackagedBytes): void {
    const own = name === TABLE ? `${baseOf(this.#studio.character.name)}-${name}` : name;
    download(bytes, own, name.endsWith('.xml') ? 'application/xml' : 'application/octet-stream');
  }
}

/** What a file of the encoder is. */
function kindOf(name: string): string {
  return name.endsWith('.gbsd.xml') ? 'gBSD' : name === TABLE ? 'AQoS' : 'the stream';
}

/** A number with two digits. */
function rounded(value: number): number {
  return Number(value.toPrecision(2));
}
