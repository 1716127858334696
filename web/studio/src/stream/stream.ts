import { ArticulaStream } from '@articula/three';
import { Box3 } from 'three';

import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';
import { button, choice, section, segmented, slider } from '../ui/controls.js';
import { Course } from '../ui/course.js';
import { h, inBytes } from '../ui/dom.js';
import { Readout } from '../ui/status.js';
import type { Viewport } from '../view/viewport.js';
import { StreamBeside } from './beside.js';
import { CarriedShow } from './carried.js';
import { EncoderPanel } from './encoder.js';
import { EventLog } from './events.js';
import { contextOf, reasonOf } from './reasons.js';
import { characters, SERVER, sessions } from './server.js';

/** Rates that the slider stops at, in kilobits per second; the last is as many as come. */
const RATES = [16, 32, 64, 128, 256, 512, 1000, 2000, 4000, 8000, 16_000, 0];
/** Milliseconds between two values of the plot, and between two looks at the sessions. */
const PLOT_MS = 250;
const SESSIONS_MS = 2000;
/** Values of the plot: half a minute. */
const KEPT = 120;
const MEGABYTE = 1e6;

/** A character of the server while it arrives: what has come, what is shown of it, and how the rate steers that. */
export class StreamPage {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  stream: ArticulaStream | undefined;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #readout = new Readout();
  readonly #log = new EventLog();
  readonly #course = new Course({
    label: 'Kilobits per second and bound of the error in pixels over the last half minute',
    lines: ['kbit/s', 'error, px'],
    least: [100, 1],
    kept: KEPT,
  });
  readonly #note = h('div', { class: 'overlay-note', role: 'status', hidden: true });
  readonly #reason = h('p', { class: 'said' });
  readonly #beside = new StreamBeside();
  /** Sound, captions and pictures that the character carries. */
  readonly carried: CarriedShow;
  readonly #sessions = h('tbody', {});
  readonly #encoder: EncoderPanel;
  readonly #character: ReturnType<typeof choice>;
  readonly #clip: ReturnType<typeof choice>;
  #timers: number[] = [];
  #frames = 0;
  #bytes = 0;
  #isFitted = false;
  #level = 0;

  constructor(studio: Studio, viewport: Viewport) {
    this.#studio = studio;
    this.#viewport = viewport;
    this.#encoder = new EncoderPanel(studio);
    this.carried = new CarriedShow(studio.notices);
    const { state } = studio;
    const steer = (change: Partial<StudioState>): void => {
      studio.set(change);
      this.stream?.setContext(this.#context());
      this.#beside.stream?.setContext(this.#context(studio.state.beside));
      this.#log.say(contextOf(studio.state));
    };
    const again = (change: Partial<StudioState>): void => {
      studio.set(change);
      this.#connect();
    };
    this.#character = choice('Character', [], '', (character) => again({ character, clip: '' }));
    this.#clip = choice('Clip', [], '', (clip) => {
      studio.set({ clip });
      this.stream?.play(clip);
      this.#beside.play(clip);
    });
    const by = segmented('Who decides', [['session', 'The server'], ['http', 'This page']], state.by, (word) => again({ by: word as StudioState['by'] }));
    const rate = slider({
      label: 'Bandwidth',
      min: 0,
      max: RATES.length - 1,
      step: 1,
      value: Math.max(RATES.indexOf(state.kbps), 0),
      shown: (i) => (RATES[i] === 0 ? 'as it comes' : `${(RATES[i] ?? 0).toLocaleString('en')} kbit/s`),
      onInput: (i) => steer({ kbps: RATES[i] ?? 0 }),
    });
    const others = RATES.slice(0, -1).map((kbps) => [String(kbps), `${kbps.toLocaleString('en')} kbit/s`] as const);
    const beside = choice('Another session at', [['0', 'none'], ...others], String(state.beside), (kbps) => again({ beside: Number(kbps) }));
    const wanted = slider({ label: 'Tolerated error', min: 0, max: 8, step: 0.25, value: state.wanted, shown: (px) => `${px} px`, onInput: (px) => steer({ wanted: px }) });
    const memory = slider({ label: 'Memory for it', min: 0, max: 64, step: 1, value: state.memory, shown: (mb) => (mb === 0 ? 'any' : `${mb} MB`), onInput: (mb) => steer({ memory: mb }) });
    const anew = button('Begin anew', () => this.#connect(), 'primary');
    const head = h('tr', {}, ...['No.', 'Character', 'Level', 'kbit/s', 'Sent'].map((text) => h('th', { scope: 'col' }, text)));
    const table = h('table', {}, h('caption', {}, 'Open now, of all pages and programs'), h('thead', {}, head), this.#sessions);
    this.main = h('div', { class: 'stage crowd' }, h('div', { class: 'picture-frame' }, this.carried.element, this.#note));
    this.panel = h('div', { class: 'panel-body' },
      section('What has come', true, this.#reason, this.#readout.element, this.#course.element),
      section('Delivery', true, this.#character.element, this.#clip.element, by.element, rate.element, beside.element, wanted.element, memory.element, h('p', { class: 'hint' }, 'Move the camera away, and less is asked for.'), h('div', { class: 'buttons' }, anew)),
      section('Events', true, this.#log.element),
      section('Sessions of the server', false, h('div', { class: 'table-scroll', tabindex: 0, role: 'region', 'aria-label': 'Sessions' }, table)),
      this.#encoder.element);
  }

  mount(): void {
    this.#encoder.renew();
    this.#viewport.columns = [];
    this.#viewport.showIn(this.main, (dt) => this.#frame(dt));
    this.#timers = [window.setInterval(() => this.#plot(), PLOT_MS), window.setInterval(() => void this.#list(), SESSIONS_MS)];
    void this.#find();
  }

  unmount(): void {
    this.#timers.forEach((timer) => clearInterval(timer));
    this.#end();
  }

  /** Asks the server what it has, and begins with what the state names. */
  async #find(): Promise<void> {
    this.#say('Asking the server…');
    const found = await characters();
    if (!this.main.isConnected) {
      return;
    }
    if (found === undefined) {
      this.#say('These pages come from a server without characters.', 'Serve a folder of them with its pages:', 'articula serve FOLDER --studio web/studio/dist');
      return;
    }
    if (found.length === 0) {
      this.#say('The folder of the server is empty.', 'Put a GLB, VRM or FBX file there and start it again.');
      return;
    }
    this.#character.fill(found.map(({ name }) => [name, name] as const));
    const { character } = this.#studio.state;
    const named = found.find(({ name }) => name === character) ?? found.find(({ manifest }) => manifest !== null) ?? found[0];
    this.#studio.set({ character: named?.name ?? '' });
    this.#character.set(this.#studio.state.character);
    this.#connect();
  }

  #connect(): void {
    this.#end();
    const { character, by, clip } = this.#studio.state;
    if (character === '') {
      return;
    }
    this.#log.begin();
    this.#course.clear();
    this.#clip.fill([]);
    [this.#bytes, this.#isFitted, this.#level] = [0, false, 0];
    this.#say(`Waiting for ${character}…`);
    this.#log.say(`asks for ${character}, ${by === 'session' ? 'in a session' : 'over HTTP'}`);
    const stream = new ArticulaStream(SERVER, character, { by, context: this.#context() });
    this.stream = stream;
    stream.addEventListener('state', ({ state }) => {
      this.#log.say(state === 'complete' ? 'all that is asked for is here' : state === 'base' ? 'the base is here' : 'connecting');
      if (state === 'base' && stream.clips.includes(clip)) {
        stream.play(clip);
      }
    });
    stream.addEventListener('refined', ({ mesh }) => {
      const triangles = (mesh.geometry.index?.count ?? 0) / 3;
      this.#log.say(`shows ${triangles.toLocaleString('en')} triangles, ${inBytes(stream.report?.bytes ?? 0)} received`);
    });
    stream.addEventListener('lost', ({ why }) => this.#log.say(`the server is lost and tried again: ${why}`));
    stream.addEventListener('error', ({ error }) => {
      this.#log.say(error.message);
      this.#studio.notices.fault(error);
    });
    this.#viewport.scene.add(stream);
    const { beside } = this.#studio.state;
    if (beside > 0) {
      this.#beside.begin(this.#viewport.scene, character, { by, context: this.#context(beside) });
    }
  }

  #end(): void {
    this.stream?.dispose();
    this.stream = undefined;
    this.#beside.end();
    this.carried.end();
    this.#reason.textContent = '';
  }

  /** What the page tells of network, device and viewer. */
  #context(kbps = this.#studio.state.kbps): NonNullable<ConstructorParameters<typeof ArticulaStream>[2]>['context'] & object {
    const { wanted, memory } = this.#studio.state;
    const { width, height } = this.#viewport.columnSize;
    return {
      network: kbps > 0 ? { available_bps: 1000 * kbps } : {},
      terminal: { width_px: Math.round(width), height_px: Math.round(height), ...(memory > 0 && { memory_bytes: MEGABYTE * memory }) },
      preferences: { tolerance_px: wanted },
    };
  }

  #frame(dtSecs: number): void {
    const { stream } = this;
    if (stream === undefined) {
      return;
    }
    this.#frames += 1;
    const camera = this.#isFitted ? this.#viewport.camera : undefined;
    stream.update(dtSecs, camera);
    this.#beside.update(dtSecs, camera);
    this.carried.follow(stream);
    const sphere = stream.mesh?.boundingSphere;
    if (!this.#isFitted && sphere && sphere.radius > 0) {
      this.#isFitted = true;
      this.#note.hidden = true;
      const box = sphere.getBoundingBox(new Box3());
      this.#viewport.fit(box, 0);
      this.#beside.stand(box);
      this.#clip.fill(stream.clips.map((name) => [name, name] as const));
    }
    this.#tell(stream);
  }

  #tell(stream: ArticulaStream): void {
    const { report } = stream;
    if (report === undefined) {
      return;
    }
    const { level, levels, target } = report;
    const reason = reasonOf(report, this.#studio.state);
    if (reason !== this.#reason.textContent) {
      this.#reason.textContent = reason;
    }
    if (level !== this.#level && level > 0) {
      this.#log.say(`level ${level} of ${levels}: ${reason}`);
    }
    this.#level = level;
    this.#readout.set('The other session', this.#beside.said);
    this.#readout.set('Level', level === 0 ? 'nothing yet' : `${level} of ${levels}`);
    this.#readout.set('The rate carries', `level ${target}`);
    this.#readout.set('Level of articulation', report.loa?.toString());
    this.#readout.set('Joints that move', report.joints?.toString());
    this.#readout.set('Mesh level', report.meshLevel?.toString());
    this.#readout.set('Texture', report.texturePx === undefined ? undefined : `${report.texturePx} px`);
    this.#readout.set('Bound of the error', report.errorPx === undefined ? undefined : `${report.errorPx.toFixed(2)} px`);
    this.#readout.set('Received', inBytes(report.bytes));
    this.#readout.set('Waited for bytes', `${report.stalls} ${report.stalls === 1 ? 'time' : 'times'}`);
  }

  #plot(): void {
    const report = this.stream?.report;
    if (report === undefined) {
      return;
    }
    const perSecond = 1000 / PLOT_MS;
    this.#readout.set('Pictures a second', `${Math.round(this.#frames * perSecond)}`);
    this.#frames = 0;
    this.#course.add((8 * perSecond * (report.bytes - this.#bytes)) / 1000, report.errorPx ?? 0);
    this.#course.draw();
    this.#bytes = report.bytes;
  }

  async #list(): Promise<void> {
    if (this.stream === undefined) {
      return;
    }
    const rows = (await sessions()).map(({ number, characters: of, sent }) =>
      h('tr', {},
        h('td', { class: 'number' }, `${number}`),
        h('td', {}, of.map(({ name }) => name).join(', ')),
        h('td', { class: 'number' }, of.map(({ level, levels }) => `${level}/${levels}`).join(', ')),
        h('td', { class: 'number' }, (sent.bandwidth_bps / 1000).toFixed(0)),
        h('td', { class: 'number' }, inBytes(sent.bytes))));
    this.#sessions.replaceChildren(...rows);
  }

  #say(text: string, more = '', command = ''): void {
    this.#note.replaceChildren(h('div', { class: 'empty' }, h('strong', {}, text), more !== '' && h('p', {}, more), command !== '' && h('code', {}, command)));
    this.#note.hidden = false;
  }
}
