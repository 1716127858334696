import { StageColumn } from '../stage/column.js';
import { chosenClip, loopedSecs, type Studio } from '../studio.js';
import { button, section, slider } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import { TaskLine } from '../ui/status.js';
import type { Viewport } from '../view/viewport.js';

const APPLICATIONS = [
  ['body', 'Body', 'One walking figure, drawn by the processor'],
  ['face', 'Face', 'A close-up of a moving face, drawn by the processor'],
  ['crowd', 'Crowd', 'Poses of many figures, not drawn'],
] as const;
type Application = (typeof APPLICATIONS)[number][0];

/** A grade of the content on the reference machine, as far as it is shown. */
interface Reference {
  readonly number: number;
  readonly figures: number;
  readonly loa: number;
  readonly size_px: readonly [number, number];
  readonly fps: number;
}

/** The result of `Tools.benchmark`, as far as it is shown. */
interface Result {
  readonly score: number;
  readonly full_fps: number;
  readonly holds: readonly { readonly fps: number; readonly grade: Reference | null }[];
  readonly grades: readonly { readonly grade: number; readonly fps: number }[];
  readonly reference: readonly Reference[];
}

/** What the program plays too, so that scores can be compared with those of other devices. */
const MANNEQUIN = './mannequin.glb';
/** Yaw of the camera from the front in radians. */
const YAW = 0.5;

/** What this device can play, by content of known size, beside the reference machine. */
export class DevicesPage {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #task = new TaskLine();
  readonly #out = new Map<Application, HTMLElement>();
  #column: StageColumn | undefined;
  #secs = 0;

  constructor(studio: Studio, viewport: Viewport) {
    this.#studio = studio;
    this.#viewport = viewport;
    const { state } = studio;
    const seconds = slider({ label: 'At most', min: 1, max: 30, step: 1, value: state.seconds, shown: (n) => `${n} s each`, onInput: (n) => studio.set({ seconds: n }) });
    const run = button('Run all three', () => void this.run(), 'primary');
    const about = h('p', { class: 'hint' }, 'Plays the mannequin at graded sizes in a worker, until it is certain which grade holds 25 and 60 frames a second. 100 % is the reference machine. The command articula bench device does the same.');
    const results = APPLICATIONS.map(([key, title, text]) => {
      const out = h('div', { class: 'results', 'aria-live': 'polite' });
      this.#out.set(key, out);
      return section(title, true, h('p', { class: 'hint' }, text), out);
    });
    this.main = h('div', { class: 'stage crowd' }, h('div', { class: 'picture-frame' }));
    this.panel = h('div', { class: 'panel-body' }, section('This device', true, about, seconds.element, run, this.#task.element), ...results);
    studio.addEventListener('character', () => this.#renew());
  }

  mount(): void {
    this.#viewport.showIn(this.main, (dt) => this.#frame(dt));
    this.#renew();
  }

  unmount(): void {
    this.#task.cancel();
    this.#column?.dispose();
    this.#column = undefined;
  }

  /** Plays all content, one application after the other. */
  async run(): Promise<void> {
    const { articula, state, notices } = this.#studio;
    try {
      const response = await fetch(MANNEQUIN);
      const bytes = new Uint8Array(await response.arrayBuffer());
      // Frames of the page would take time of the device.
      this.#viewport.run(false);
      for (const [application, title] of APPLICATIONS) {
        const found = await this.#task.run(`Playing ${title.toLowerCase()}`, (watch) =>
          articula.tools.benchmark(bytes, 'mannequin.glb', { application, seconds: state.seconds, ...watch }),
        );
        this.#show(application, found as Result);
      }
    } catch (error) {
      notices.fault(error);
    } finally {
      this.#viewport.run(true);
    }
  }

  #show(application: Application, result: Result): void {
    const out = this.#out.get(application);
    if (out === undefined) {
      return;
    }
    const holds = result.holds.map(({ fps, grade }) => `${fps} frames a second: ${grade === null ? 'none' : inWords(application, grade)}`);
    const rows = result.grades.map(({ grade, fps }) => {
      const reference = result.reference[grade];
      const predicted = ((reference?.fps ?? 0) * result.score) / 100;
      return h('tr', {},
        h('td', {}, reference === undefined ? String(grade) : inWords(application, reference)),
        ...[fps, predicted, reference?.fps ?? 0].map((value) => h('td', { class: 'number' }, value.toFixed(value < 100 ? 1 : 0))));
    });
    const head = ['Content', 'Measured', 'Predicted', 'At\u00a0100\u00a0%'].map((text) => h('th', { scope: 'col' }, text));
    const caption = 'Frames a second';
    const table = h('table', {}, h('caption', {}, caption), h('thead', {}, h('tr', {}, ...head)), h('tbody', {}, ...rows));
    out.dataset.result = JSON.stringify(result);
    out.replaceChildren(
      h('p', { class: 'said' }, `${result.score.toFixed(0)} % of the reference machine; all of it at ${result.full_fps.toFixed(1)} frames a second.`),
      h('p', { class: 'hint' }, `Finest that holds ${holds.join('; ')}.`),
      h('div', { class: 'table-scroll', tabindex: 0, role: 'region', 'aria-label': `${caption}, ${application}` }, table));
  }

  #renew(): void {
    if (!this.#viewport.isIn(this.main)) {
      return;
    }
    this.#column?.dispose();
    const { asset } = this.#studio.character;
    const joints = Uint32Array.from(asset.joints, (_, joint) => joint);
    this.#column = new StageColumn(asset, { title: '', joints, measured: false });
    this.#column.dress({ ...this.#studio.state, body: 'solid', skeleton: false });
    this.#viewport.columns = [];
    this.#viewport.scene.add(this.#column.root);
    this.#viewport.fit(asset.bounds, YAW);
    if (asset.clips.length > 0) {
      this.#column.play(chosenClip(this.#studio), 0);
    }
  }

  #frame(dtSecs: number): void {
    this.#secs = loopedSecs(this.#studio, this.#secs + dtSecs);
    this.#column?.update(performance.now() / 1000, this.#secs, this.#viewport);
  }
}

/** A grade in words. */
function inWords(application: Application, { figures, loa, size_px: [width, height] }: Reference): string {
  return application === 'crowd' ? `${figures.toLocaleString('en')} figures` : `LoA ${loa}, ${width}×${height}`;
}
