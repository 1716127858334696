import type { ArticulaStream } from '@articula/three';

import { VoiceSound } from '../stage/voice.js';
import { h } from '../ui/dom.js';
import type { Notices } from '../ui/status.js';
import { type Cue, cueAt, readCues } from './captions.js';

type File = ArticulaStream['carried'][number];

/** What a character carries beside its motion: sound, captions and a slide-show, all on the clock of the clip that plays. */
export class CarriedShow {
  readonly element: HTMLElement;
  readonly sound: VoiceSound;
  readonly #slide = h('img', { class: 'slide', alt: '', hidden: true });
  readonly #caption = h('p', { class: 'caption', hidden: true });
  #cues: readonly Cue[] | undefined;
  /** Addresses of the pictures that have come, by their names. */
  readonly #pictures = new Map<string, string>();
  #clip: string | undefined;
  #sounds = '';
  #secs = 0;

  constructor(notices: Notices) {
    this.sound = new VoiceSound(notices);
    this.element = h('div', { class: 'carried' }, this.#slide, h('div', { class: 'carried-foot' }, this.#caption, this.sound.element));
  }

  /** Shows a moment of what plays. */
  follow(stream: ArticulaStream): void {
    const { carried } = stream;
    const { clip, clipSecs: secs } = stream;
    // A clip that waits for its bytes stands, and its sound with it.
    const goes = secs !== this.#secs && clip !== undefined;
    this.#secs = secs;
    this.#hear(stream, carried.filter(({ mime }) => mime.startsWith('audio/')), clip);
    this.sound.follow(secs, goes, 1);
    this.#take(stream, carried);
    const isPicture = ({ text }: Cue): boolean => carried.some(({ file }) => nameOf(file) === text);
    const cues = this.#cues ?? [];
    this.#say(cueAt(cues.filter((cue) => !isPicture(cue)), clip, secs)?.text);
    this.#show(cueAt(cues.filter(isPicture), clip, secs)?.text);
  }

  /** Forgets all of a character. */
  end(): void {
    this.sound.end();
    this.sound.load(undefined);
    this.#pictures.forEach((url) => URL.revokeObjectURL(url));
    this.#pictures.clear();
    [this.#cues, this.#clip, this.#sounds] = [undefined, undefined, ''];
    this.#say(undefined);
    this.#show(undefined);
  }

  /** Takes over the sound of a clip: that with its name, else one that has the name of none. */
  #hear(stream: ArticulaStream, sounds: readonly File[], clip: string | undefined): void {
    const own = sounds.find(({ file }) => stemOf(file) === clip) ?? sounds.find(({ file }) => !stream.clips.includes(stemOf(file)));
    const wanted = own?.file ?? '';
    if (wanted === this.#sounds && clip === this.#clip) {
      return;
    }
    const bytes = own && stream.carriedFile(own.file);
    if (own === undefined || bytes !== undefined) {
      [this.#sounds, this.#clip] = [wanted, clip];
      this.sound.load(bytes, own?.mime);
    }
  }

  /** Takes over captions and pictures that have come. */
  #take(stream: ArticulaStream, carried: readonly File[]): void {
    const captions = carried.find(({ mime }) => mime === 'text/vtt');
    if (this.#cues === undefined && captions !== undefined) {
      const bytes = stream.carriedFile(captions.file);
      this.#cues = bytes && readCues(new TextDecoder().decode(bytes));
    }
    for (const { file, mime } of carried) {
      const name = nameOf(file);
      if (mime.startsWith('image/') && !this.#pictures.has(name)) {
        const bytes = stream.carriedFile(file);
        if (bytes !== undefined) {
          this.#pictures.set(name, URL.createObjectURL(new Blob([bytes as BlobPart], { type: mime })));
        }
      }
    }
  }

  #say(text: string | undefined): void {
    this.#caption.hidden = text === undefined;
    if (text !== undefined && this.#caption.textContent !== text) {
      this.#caption.textContent = text;
    }
  }

  #show(name: string | undefined): void {
    const url = this.#pictures.get(name ?? '');
    this.#slide.hidden = url === undefined;
    if (url !== undefined && this.#slide.src !== url) {
      this.#slide.src = url;
      this.#slide.alt = stemOf(name ?? '');
    }
  }
}

function nameOf(file: string): string {
  return file.split('/').at(-1) ?? file;
}

function stemOf(file: string): string {
  return nameOf(file).replace(/\.[^.]*$/, '');
}
