import { button } from '../ui/controls.js';
import type { Notices } from '../ui/status.js';

/** Seconds by which sound and clip may differ before the sound is set anew. */
const APART_SECS = 0.12;

/** The sound of a clip, heard on its clock. */
export class VoiceSound {
  /** Turns it on and off; hidden where the clip is silent. */
  readonly element = button('Sound', () => this.#toggle(), 'small');
  readonly audio = new Audio();
  readonly #notices: Notices;
  #recording: Uint8Array | undefined;
  #isOn = true;

  constructor(notices: Notices) {
    this.#notices = notices;
    this.element.hidden = true;
    this.#paint();
  }

  /** Takes over the recording of a clip, a WAV file or another of this media type, or none. */
  load(recording: Uint8Array | undefined, type = 'audio/wav'): void {
    if (recording === this.#recording) {
      return;
    }
    this.end();
    URL.revokeObjectURL(this.audio.src);
    this.#recording = recording;
    this.element.hidden = recording === undefined;
    if (recording === undefined) {
      this.audio.removeAttribute('src');
    } else {
      this.audio.src = URL.createObjectURL(new Blob([recording as BlobPart], { type }));
    }
  }

  /** Takes over a moment of the clip. */
  follow(secs: number, isPlaying: boolean, speed: number): void {
    const { audio } = this;
    if (this.#recording === undefined) {
      return;
    }
    const isHeard = isPlaying && this.#isOn && secs < (audio.duration || Infinity);
    if (Math.abs(audio.currentTime - secs) > (isHeard ? APART_SECS * speed : 0)) {
      audio.currentTime = secs;
    }
    audio.playbackRate = speed;
    if (isHeard && audio.paused) {
      audio.play().catch((error: unknown) => this.#refused(error));
    } else if (!isHeard) {
      audio.pause();
    }
  }

  end(): void {
    this.audio.pause();
  }

  /** Browsers play no sound before the visitor has touched the page. */
  #refused(error: unknown): void {
    const { name } = error as DOMException;
    if (name === 'AbortError' || !this.#isOn) {
      return;
    }
    this.#isOn = false;
    this.#paint();
    this.#notices.say(name === 'NotAllowedError' ? 'It is silent until you press Sound.' : `The browser plays no sound of this file: ${(error as Error).message}`);
  }

  #toggle(): void {
    this.#isOn = !this.#isOn;
    this.#paint();
  }

  #paint(): void {
    this.element.setAttribute('aria-pressed', String(this.#isOn));
  }
}
