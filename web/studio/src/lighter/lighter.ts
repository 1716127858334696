import { ArticulaAsset } from '@articula/three';

import { StageColumn } from '../stage/column.js';
import type { StudioState } from '../state.js';
import { chosenClip, loopedSecs, type SourceFile, type Studio } from '../studio.js';
import { button, choice, section, slider, toggle } from '../ui/controls.js';
import { download, h, inBytes } from '../ui/dom.js';
import { Readout, TaskLine } from '../ui/status.js';
import type { Viewport } from '../view/viewport.js';
import { clipsTable, type OptimizeReport, partsTable } from './report.js';

/** Yaw of the camera from the front in radians. */
const YAW = 0.5;

/** The file as it was given beside the same in fewer bytes, both on one clock. */
export class LighterPage {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  /** The character before and, once it is made, after. */
  columns: StageColumn[] = [];
  /** The file that was made. */
  made: Uint8Array | undefined;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #task = new TaskLine();
  readonly #readout = new Readout();
  readonly #tables = h('div', { class: 'results' });
  readonly #labels = h('div', { class: 'column-labels', hidden: true });
  readonly #clip: ReturnType<typeof choice>;
  readonly #download: HTMLButtonElement;
  #asset: ArticulaAsset | undefined;
  /** What it was made of. */
  #of: SourceFile | undefined;
  #secs = 0;

  constructor(studio: Studio, viewport: Viewport) {
    this.#studio = studio;
    this.#viewport = viewport;
    const { state } = studio;
    const set = (change: Partial<StudioState>): void => studio.set(change);
    const lost = slider({ label: 'Error in motion', min: 0.25, max: 8, step: 0.25, value: state.lost, shown: (px) => `${px} px`, hint: 'Of any vertex at any time, where the figure fills a picture of 720 lines.', onInput: (px) => set({ lost: px }) });
    const compress = choice('Arrays', [['ext', 'EXT_meshopt_compression'], ['khr', 'KHR_meshopt_compression'], ['quantize', 'integers, not compressed'], ['none', 'not compressed']], state.compress, (word) => set({ compress: word as StudioState['compress'] }));
    const keys = toggle('Keep all keys', state.keys, (on) => set({ keys: on }));
    const fine = toggle('Keep all triangles', state.fine, (on) => set({ fine: on }));
    const pictures = toggle('Keep pictures', state.pictures, (on) => set({ pictures: on }));
    const attributes = toggle('Keep attributes that no material uses', state.attributes, (on) => set({ attributes: on }));
    const make = button('Make it lighter', () => void this.make(), 'primary');
    this.#download = button('Download', () => this.#save());
    this.#clip = choice('Clip', [], '', (clip) => {
      set({ clip });
      this.#play();
    });
    this.main = h('div', { class: 'stage crowd' }, h('div', { class: 'picture-frame' }, this.#labels));
    this.panel = h('div', { class: 'panel-body' },
      section('Lighter', true, lost.element, compress.element, keys.element, fine.element, pictures.element, attributes.element, h('div', { class: 'buttons' }, make, this.#download), this.#task.element),
      section('Bytes and errors', true, this.#clip.element, this.#readout.element, this.#tables, h('p', { class: 'hint' }, 'The error is measured on the file that was written: it is read again, and every vertex that is left is compared at all key times, their middles and random times, and the surfaces where triangles are gone. The command articula optimize does the same.')));
    studio.addEventListener('character', () => this.#renew());
  }

  mount(): void {
    this.#viewport.showIn(this.main, (dt) => this.#frame(dt));
    this.#renew();
  }

  unmount(): void {
    this.#task.cancel();
    this.#clear();
    this.#asset?.dispose();
    this.#asset = undefined;
  }

  /** Makes the file in a worker and shows it beside the one that was given. */
  async make(): Promise<void> {
    const { source, state, articula } = this.#studio;
    try {
      const made = await this.#task.run(`Making ${source.name} lighter`, (watch) =>
        articula.tools.optimize(source.bytes, source.name, { errorPx: state.lost, compress: state.compress, keepKeys: state.keys, keepTriangles: state.fine, keepTextures: state.pictures, keepAttributes: state.attributes, ...watch }),
      );
      const asset = await ArticulaAsset.of(articula, articula.open(made.bytes, 'lighter.glb'));
      if (!this.#isShown || source !== this.#studio.source) {
        asset.dispose();
        return;
      }
      const before = this.#asset;
      this.#asset = asset;
      this.#of = source;
      this.made = made.bytes;
      this.#tell(made.report as OptimizeReport);
      this.#show();
      before?.dispose();
    } catch (error) {
      this.#studio.notices.fault(error);
    }
  }

  get #isShown(): boolean {
    return this.#viewport.isIn(this.main);
  }

  #tell(report: OptimizeReport): void {
    const share = report.bytes_out / Math.max(this.#studio.source.bytes.length, 1);
    this.#readout.set('After', `${inBytes(report.bytes_out)}, ${(100 * share).toFixed(0)} %`);
    this.#readout.set('Triangles', `${report.triangles_out.toLocaleString('en')} of ${report.triangles_in.toLocaleString('en')}`);
    this.#readout.set('Error measured', `${report.error_mm.toFixed(2)} of ${report.bound_mm.toFixed(2)} mm`);
    this.#tables.replaceChildren(partsTable(report), ...(report.clips.length > 0 ? [clipsTable(report)] : []));
    this.#download.disabled = false;
  }

  #save(): void {
    if (this.made !== undefined) {
      const { name } = this.#studio.source;
      const extension = /\.vrm$/i.test(name) ? 'vrm' : 'glb';
      download(this.made, `${name.replace(/\.[a-z0-9]+$/i, '')}-lighter.${extension}`, 'model/gltf-binary');
    }
  }

  /** Begins anew with another file. */
  #renew(): void {
    if (!this.#isShown) {
      return;
    }
    if (this.#asset !== undefined && this.#of === this.#studio.source) {
      // The same file, with its tables.
      this.#show();
      return;
    }
    this.#clear();
    this.#asset?.dispose();
    [this.#asset, this.made] = [undefined, undefined];
    this.#download.disabled = true;
    this.#readout.set('Before', inBytes(this.#studio.source.bytes.length));
    this.#readout.set('After', undefined);
    this.#readout.set('Triangles', undefined);
    this.#readout.set('Error measured', undefined);
    this.#tables.replaceChildren();
    const { asset } = this.#studio.character;
    this.#clip.fill(asset.clips.map((name) => [name, name] as const));
    this.#clip.set(asset.clips[chosenClip(this.#studio)] ?? '');
    this.#show();
  }

  /** Shows the character, and beside it the lighter one if there is one. */
  #show(): void {
    this.#clear();
    const { asset } = this.#studio.character;
    const shown = [['Before', asset] as const, ...(this.#asset === undefined ? [] : [['After', this.#asset] as const])];
    this.columns = shown.map(([title, of]) => {
      const joints = Uint32Array.from(of.joints, (_, joint) => joint);
      const column = new StageColumn(of, { title, joints, measured: false });
      column.dress({ ...this.#studio.state, body: 'solid', skeleton: false });
      this.#viewport.scene.add(column.root);
      return column;
    });
    this.#viewport.columns = this.columns;
    const bytes = [this.#studio.source.bytes.length, this.made?.length ?? 0];
    this.#labels.replaceChildren(...this.columns.map(({ title }, i) => h('div', {}, h('span', {}, title), h('small', {}, inBytes(bytes[i] ?? 0)))));
    this.#labels.hidden = this.columns.length < 2;
    this.#labels.style.gridTemplateColumns = `repeat(${this.#viewport.grid.across}, 1fr)`;
    this.#viewport.fit(asset.bounds, YAW);
    this.#play();
  }

  #clear(): void {
    this.columns.forEach((column) => column.dispose());
    this.columns = [];
    this.#viewport.columns = [];
  }

  #play(): void {
    const { asset } = this.#studio.character;
    this.#secs = 0;
    if (asset.clips.length > 0) {
      this.columns.forEach((column) => column.play(chosenClip(this.#studio), 0));
    }
  }

  #frame(dtSecs: number): void {
    this.#secs = loopedSecs(this.#studio, this.#secs + dtSecs);
    const now = performance.now() / 1000;
    this.columns.forEach((column) => column.update(now, this.#secs, this.#viewport));
  }
}
