import type { StudioState } from '../state.js';
import { baseOf } from '../files.js';
import { chosenClip, loopedSecs, type Studio } from '../studio.js';
import { StageColumn } from '../stage/column.js';
import { button, choice, section, segmented, slider } from '../ui/controls.js';
import { download, h, inBytes } from '../ui/dom.js';
import { Readout, TaskLine } from '../ui/status.js';
import type { Viewport } from '../view/viewport.js';
import { type Background, PICTURES, readBackground, withBackground } from './background.js';
import { type Preview, preview } from './preview.js';

/** The report of `articula flatten --json`, as far as it is shown. */
interface Report {
  readonly bytes: { readonly raw: number; readonly gzip: number; readonly brotli: number };
  readonly triangles_of_character: number;
  readonly triangles_drawn: number;
  readonly frames: number;
  readonly fps: number;
  readonly error: { readonly position_rmse_px: number; readonly image_rmse_levels: number; readonly ssim: number; readonly pixels_off_percent: number };
}

/** Share of a square picture that the character is high in 2D, and so in 3D beside it. */
const FILLED = 0.86;
const NAMES = { svg: 'Animated SVG', player: 'Player', lottie: 'Lottie' } as const;
const FILES = {
  svg: ['svg', 'image/svg+xml'],
  player: ['js', 'text/javascript'],
  lottie: ['lottie.json', 'application/json'],
} as const;

/** The character in 3D beside what it becomes in 2D, with bytes and errors. */
export class FlatPage {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #task = new TaskLine();
  readonly #readout = new Readout();
  readonly #shown = h('div', { class: 'flat-picture' });
  readonly #clip: ReturnType<typeof choice>;
  readonly #download: HTMLButtonElement;
  #column: StageColumn | undefined;
  #preview: Preview | undefined;
  #background: Background | undefined;
  readonly #backdrop = h('img', { class: 'backdrop', alt: '', hidden: true });
  readonly #remove = button('Remove it', () => this.#stand(undefined));
  readonly #named = h('p', { class: 'hint', hidden: true });
  #made: { bytes: Uint8Array; form: StudioState['form']; name: string } | undefined;
  #secs = 0;
  /** Size of the view that the camera stands for. */
  #size: readonly [number, number] = [0, 0];

  constructor(studio: Studio, viewport: Viewport) {
    this.#studio = studio;
    this.#viewport = viewport;
    const { state } = studio;
    const set = (change: Partial<StudioState>): void => studio.set(change);
    const form = segmented('Form', [['svg', 'SVG'], ['player', 'Player'], ['lottie', 'Lottie']], state.form, (word) => set({ form: word as StudioState['form'] }));
    this.#clip = choice('Clip', [], '', (word) => {
      set({ clip: word });
      this.#play();
    });
    const triangles = slider({ label: 'Triangles', min: 0, max: 4000, step: 100, value: state.triangles, shown: (n) => (n === 0 ? 'as needed' : `about ${n}`), onInput: (n) => set({ triangles: n }) });
    const yaw = slider({ label: 'Seen from', min: -180, max: 180, step: 5, value: state.yaw, shown: (deg) => (deg === 0 ? 'the front' : `${deg}°`), onInput: (deg) => {
      set({ yaw: deg });
      this.#look();
    } });
    const make = button('Make the picture', () => void this.make(), 'primary');
    this.#download = button('Download', () => this.#save());
    this.#download.disabled = true;
    const picker = h('input', { type: 'file', accept: PICTURES, hidden: true, 'aria-label': 'Background picture' });
    picker.addEventListener('change', () => {
      const file = picker.files?.[0];
      if (file !== undefined) {
        readBackground(file).then((read) => this.#stand(read), (error: unknown) => studio.notices.fault(error));
      }
      picker.value = '';
    });
    const behind = h('div', { class: 'buttons' }, button('Choose a background', () => picker.click()), this.#remove, picker);
    const frame = h('figure', { class: 'picture-frame' }, h('figcaption', {}, '3D'));
    const flat = h('figure', { class: 'picture-frame flat-frame' }, h('figcaption', {}, '2D'), this.#backdrop, this.#shown);
    this.main = h('div', { class: 'stage flat' }, frame, flat);
    this.panel = h('div', { class: 'panel-body' },
      section('Picture', true, form.element, this.#clip.element, triangles.element, yaw.element, behind, this.#named, h('div', { class: 'buttons' }, make, this.#download), this.#task.element),
      section('Sizes and errors', true, this.#readout.element, h('p', { class: 'hint' }, 'Errors compare the picture with the character that was simplified for it, frame by frame, as articula flatten --json tells them.')));
    this.#stand(undefined);
    this.#empty();
    studio.addEventListener('character', () => this.#renew());
  }

  mount(): void {
    this.#viewport.showIn(this.main, (dt) => this.#frame(dt));
    this.#renew();
  }

  unmount(): void {
    this.#column?.dispose();
    this.#column = undefined;
  }

  /** Makes the picture in a worker and shows it. */
  async make(): Promise<void> {
    const { bytes, name, asset } = this.#studio.character;
    const { form, triangles, yaw } = this.#studio.state;
    const clip = asset.clips[chosenClip(this.#studio)];
    try {
      const made = await this.#task.run(`Making ${NAMES[form]}`, (watch) =>
        this.#studio.articula.tools.flattenMeasured(bytes, name, {
          form,
          yawDeg: yaw,
          ...(clip !== undefined && { clip }),
          ...(triangles > 0 && { triangles }),
          ...watch,
        }),
      );
      this.#made = { bytes: made.bytes, form, name: baseOf(name) };
      this.#preview?.end();
      this.#preview = await preview(this.#shown, form, made.bytes);
      this.#download.disabled = false;
      this.#tell(made.report as Report);
    } catch (error) {
      this.#studio.notices.fault(error);
    }
  }

  #tell(report: Report): void {
    const { bytes, error } = report;
    this.#readout.set('File', inBytes(bytes.raw));
    this.#readout.set('gzip', inBytes(bytes.gzip));
    this.#readout.set('Brotli', inBytes(bytes.brotli));
    this.#readout.set('Character in 3D', inBytes(this.#studio.character.bytes.length));
    this.#readout.set('Triangles', `${report.triangles_drawn.toLocaleString('en')} of ${report.triangles_of_character.toLocaleString('en')}`);
    this.#readout.set('Frames', `${report.frames} at ${report.fps.toFixed(1)} Hz`);
    this.#readout.set('Error of corners', `${error.position_rmse_px.toFixed(2)} px`);
    this.#readout.set('Error of pixels', `${error.image_rmse_levels.toFixed(2)} of 255`);
    this.#readout.set('Similarity (SSIM)', error.ssim.toFixed(3));
    this.#readout.set('Pixels off', `${error.pixels_off_percent.toFixed(2)} %`);
  }

  #save(): void {
    if (this.#made !== undefined) {
      const [extension, type] = FILES[this.#made.form];
      const { bytes, form, name } = this.#made;
      const isFilled = form === 'svg' && this.#background !== undefined;
      download(isFilled ? withBackground(bytes, this.#background as Background) : bytes, `${name}.${extension}`, type);
    }
  }

  /** Puts a picture behind the character, or none. */
  #stand(background: Background | undefined): void {
    URL.revokeObjectURL(this.#backdrop.src);
    this.#background = background;
    this.#backdrop.hidden = background === undefined;
    if (background !== undefined) {
      this.#backdrop.src = URL.createObjectURL(new Blob([background.bytes as BlobPart], { type: background.type }));
    }
    this.#remove.hidden = this.#named.hidden = background === undefined;
    this.#named.textContent = background === undefined ? '' : `${background.name} is behind it, and in the SVG that is downloaded; sizes and errors are those of the character alone.`;
  }

  #empty(): void {
    this.#preview?.end();
    this.#preview = undefined;
    this.#made = undefined;
    this.#download.disabled = true;
    this.#shown.replaceChildren(h('div', { class: 'empty' }, h('strong', {}, 'No picture yet'), h('p', {}, 'Make one to see it beside the character, with its bytes and errors.')));
  }

  #renew(): void {
    if (!this.#viewport.isIn(this.main)) {
      return;
    }
    this.unmount();
    this.#empty();
    const { asset } = this.#studio.character;
    const joints = Uint32Array.from(asset.joints, (_, joint) => joint);
    this.#column = new StageColumn(asset, { title: '', joints, measured: false });
    this.#column.dress({ ...this.#studio.state, body: 'solid', skeleton: false });
    this.#viewport.scene.add(this.#column.root);
    this.#clip.fill(asset.clips.map((name) => [name, name] as const));
    this.#play();
    this.#look();
  }

  #play(): void {
    const { asset } = this.#studio.character;
    if (asset.clips.length > 0) {
      const clip = chosenClip(this.#studio);
      this.#clip.set(asset.clips[clip] ?? '');
      this.#column?.play(clip, 0);
    }
    this.#secs = 0;
  }

  /** Turns the camera to where the picture is seen from. */
  #look(): void {
    const { width, height } = this.#viewport.columnSize;
    const share = Math.min(width / height, 1);
    this.#viewport.fit(this.#studio.character.asset.bounds, (this.#studio.state.yaw * Math.PI) / 180, FILLED * share);
  }

  #frame(dtSecs: number): void {
    const { width, height } = this.#viewport.columnSize;
    if (this.#viewport.isFitted && (width !== this.#size[0] || height !== this.#size[1])) {
      this.#size = [width, height];
      this.#look();
    }
    this.#secs = loopedSecs(this.#studio, this.#secs + dtSecs);
    this.#column?.update(performance.now() / 1000, this.#secs, this.#viewport);
  }
}
