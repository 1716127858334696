import type { StudioState } from '../state.js';
import { baseOf } from '../files.js';
import { chosenClip, loopedSecs, type Studio } from '../studio.js';
import { StageColumn } from '../stage/column.js';
import type { RecordedCamera } from '../view/camera-path.js';
import { button, choice, section, segmented, slider } from '../ui/controls.js';
import { download, h } from '../ui/dom.js';
import { Readout, TaskLine } from '../ui/status.js';
import type { Viewport } from '../view/viewport.js';
import { type Background, PICTURES, readBackground, withBackground } from './background.js';
import { headBox } from './head-box.js';
import { type PortraitPreview, portraitWithBackground, type PortraitReport, showPortrait } from './portrait.js';
import { type Preview, preview } from './preview.js';
import { type ClipReport, tell } from './report.js';

/** Share of a square picture that the character is high in 2D, and so in 3D beside it. */
const FILLED = 0.86;
/** The same of a portrait, with what stands beside the head. */
const HEAD_FILLED = 0.88;
const NAMES = { svg: 'Animated SVG', player: 'Player', lottie: 'Lottie', portrait: 'Portrait' } as const;
const FILES = {
  svg: ['svg', 'image/svg+xml'],
  player: ['js', 'text/javascript'],
  lottie: ['lottie.json', 'application/json'],
  portrait: ['portrait.html', 'text/html'],
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
  readonly #yaw: HTMLElement;
  readonly #turn: ReturnType<typeof slider>;
  readonly #recorded = h('p', { class: 'hint', hidden: true }, 'Seen by the camera with which its recording began.');
  #column: StageColumn | undefined;
  #preview: Preview | undefined;
  /** The portrait that is shown, if that is one. */
  portrait: PortraitPreview | undefined;
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
    const form = segmented('Form', [['svg', 'SVG'], ['player', 'Player'], ['lottie', 'Lottie'], ['portrait', 'Portrait']], state.form, (word) => {
      set({ form: word as StudioState['form'] });
      this.#suit();
    });
    this.#clip = choice('Clip', [], '', (word) => {
      set({ clip: word });
      this.#play();
    });
    const triangles = slider({ label: 'Triangles', min: 0, max: 4000, step: 100, value: state.triangles, shown: (n) => (n === 0 ? 'as needed' : `about ${n}`), onInput: (n) => set({ triangles: n }) });
    this.#yaw = slider({ label: 'Seen from', min: -180, max: 180, step: 5, value: state.yaw, shown: (deg) => (deg === 0 ? 'the front' : `${deg}°`), onInput: (deg) => {
      set({ yaw: deg });
      this.#look();
    } }).element;
    this.#turn = slider({ label: 'Head of the portrait', min: -60, max: 60, step: 5, value: 0, shown: (deg) => (deg === 0 ? 'as it plays' : `turned by ${deg}°`), onInput: (deg) => this.portrait?.turn(deg) });
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
      section('Picture', true, form.element, this.#clip.element, triangles.element, this.#yaw, this.#recorded, this.#turn.element, behind, this.#named, h('div', { class: 'buttons' }, make, this.#download), this.#task.element),
      section('Sizes and errors', true, this.#readout.element, h('p', { class: 'hint' }, 'Errors compare the picture with the character that was simplified for it, frame by frame, and a portrait with the head in 3D as it turns, as articula flatten --json tells them.')));
    this.#stand(undefined);
    this.#empty();
    this.#suit();
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
    const camera = this.#camera;
    const options = { ...(clip !== undefined && { clip }), ...(triangles > 0 && { triangles }) };
    const { tools } = this.#studio.articula;
    try {
      if (form === 'portrait') {
        const made = await this.#task.run('Making the portrait', (watch) => tools.portrait(bytes, name, { ...options, ...watch }));
        this.#take({ bytes: made.page, form, name: baseOf(name) }, made.report as PortraitReport);
        this.portrait = await showPortrait(this.#shown, made.files);
        this.#preview = this.portrait;
      } else {
        const made = await this.#task.run(`Making ${NAMES[form]}`, (watch) => tools.flattenMeasured(bytes, name, { form, ...(camera === undefined ? { yawDeg: yaw } : { camera: { eye: camera.eye, target: camera.target, fovDeg: camera.fovDeg } }), ...options, ...watch }));
        this.#take({ bytes: made.bytes, form, name: baseOf(name) }, made.report as ClipReport);
        this.#preview = await preview(this.#shown, form, made.bytes);
      }
    } catch (error) {
      this.#studio.notices.fault(error);
    }
    this.#suit();
  }

  /** Takes over what was made. */
  #take(made: { bytes: Uint8Array; form: StudioState['form']; name: string }, report: ClipReport | PortraitReport): void {
    this.#preview?.end();
    this.portrait = undefined;
    this.#made = made;
    this.#download.disabled = false;
    this.#turn.set(0);
    tell(this.#readout, report, this.#studio.character.bytes.length);
  }

  /** Shows the knobs that the form has, and the head alone beside a portrait. */
  #suit(): void {
    const isHead = this.#studio.state.form === 'portrait';
    this.#yaw.hidden = isHead || this.#camera !== undefined;
    this.#recorded.hidden = isHead || this.#camera === undefined;
    this.#turn.element.hidden = !isHead || this.portrait === undefined;
    this.#look();
  }

  #save(): void {
    if (this.#made === undefined) {
      return;
    }
    const { bytes, form, name } = this.#made;
    const [extension, type] = FILES[form];
    const background = this.#background;
    const filled = background === undefined ? bytes : form === 'svg' ? withBackground(bytes, background) : form === 'portrait' ? portraitWithBackground(bytes, background) : bytes;
    Promise.resolve(filled).then(
      (all) => download(all, `${name}.${extension}`, type),
      (error: unknown) => this.#studio.notices.fault(error),
    );
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
    this.#named.textContent = background === undefined ? '' : `${background.name} is behind it, and in the SVG or portrait that is downloaded; sizes and errors are those of the character alone.`;
  }

  #empty(): void {
    this.#preview?.end();
    this.#preview = undefined;
    this.portrait = undefined;
    this.#turn.element.hidden = true;
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
  }

  #play(): void {
    const { asset } = this.#studio.character;
    if (asset.clips.length > 0) {
      const clip = chosenClip(this.#studio);
      this.#clip.set(asset.clips[clip] ?? '');
      this.#column?.play(clip, 0, this.#camera !== undefined);
    }
    this.#secs = 0;
    this.#suit();
  }

  /** The camera that the clip was recorded by. */
  get #camera(): RecordedCamera | undefined {
    const { cameras, character } = this.#studio;
    return cameras.get(character.asset.clips[chosenClip(this.#studio)] ?? '');
  }

  /** Turns the camera to where the picture is seen from. */
  #look(): void {
    const column = this.#column;
    if (column === undefined) {
      return;
    }
    const { width, height } = this.#viewport.columnSize;
    const share = Math.min(width / height, 1);
    const recorded = this.#camera;
    if (recorded !== undefined && this.#studio.state.form !== 'portrait') {
      this.#viewport.see(recorded.eye, recorded.target, share);
      return;
    }
    // What is beside it decides, once there is something.
    if ((this.#made?.form ?? this.#studio.state.form) === 'portrait') {
      this.#viewport.fit(headBox(this.#studio.character.asset, column.joints()), 0, HEAD_FILLED * share);
      return;
    }
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
