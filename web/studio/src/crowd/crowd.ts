import { ArticulaCrowd } from '@articula/three';
import { Color, Raycaster, Vector2 } from 'three';

import { heightOf } from '../stage/column.js';
import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';
import { button, section, segmented, slider, toggle, type Control } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import { Readout } from '../ui/status.js';
import type { Viewport } from '../view/viewport.js';

/** Metres between two characters. */
const SPACING = 1.5;
/** Frames between two paints of the tiers. */
const PAINT_EVERY = 12;
/** Colours of tiers, from full detail to the coarsest, in steps of lightness as well as hue. */
const TIER_COLORS = ['#2f7de1', '#27a6b4', '#3fb768', '#b5b02c', '#e8912a', '#dd4f3c', '#b0408f', '#7a4fb5'];
const WHITE = new Color(1, 1, 1);
/** Counts that the slider stops at. */
const COUNTS = [1, 9, 25, 100, 300, 1000, 3000, 10_000];

/** Many instances of the character, each at the level that its error in pixels needs. */
export class CrowdPage {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  crowd: ArticulaCrowd | undefined;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #readout = new Readout();
  readonly #tiers = h('ol', { class: 'tiers', 'aria-label': 'Characters by tier' });
  readonly #picked = h('p', { class: 'hint' }, 'Click a character to choose it.');
  readonly #note = h('div', { class: 'overlay-note', role: 'status', hidden: true });
  readonly #importance: Control<number>;
  readonly #tolerance: Control<number>;
  readonly #budget: Control<number>;
  #chosen = -1;
  #before: StudioState;
  #frames = 0;
  #frameMs = 16;
  #last = 0;

  constructor(studio: Studio, viewport: Viewport) {
    this.#studio = studio;
    this.#viewport = viewport;
    this.#before = { ...studio.state };
    const { state } = studio;
    const set = (change: Partial<StudioState>): void => studio.set(change);
    // A link may name a count that the slider would not stop at.
    const counts = [...new Set([...COUNTS, state.count])].toSorted((a, b) => a - b);
    const count = slider({ label: 'Characters', min: 0, max: counts.length - 1, step: 1, value: counts.indexOf(state.count), shown: (i) => (counts[i] ?? 0).toLocaleString('en'), onInput: (i) => set({ count: counts[i] ?? 1 }) });
    const detail = segmented('Detail by', [['tolerance', 'Error'], ['budget', 'Time'], ['full', 'All joints']], state.detail, (word) => set({ detail: word as StudioState['detail'] }));
    this.#tolerance = slider({ label: 'Tolerated error', min: 0.1, max: 16, step: 0.1, value: state.tolerance, shown: (px) => `${px.toFixed(1)} px`, onInput: (px) => set({ tolerance: px }) });
    this.#budget = slider({ label: 'Time for a frame', min: 0.02, max: 8, step: 0.02, value: state.budget, shown: (ms) => `${ms.toFixed(2)} ms`, onInput: (ms) => set({ budget: ms }) });
    this.#importance = slider({ label: 'Importance of the chosen one', min: -3, max: 3, step: 1, value: 0, shown: (x) => `${2 ** x}×`, onInput: (x) => this.#weigh(2 ** x) });
    const tiers = toggle('Colour by tier', state.tiers, (on) => set({ tiers: on }));
    const frame = h('div', { class: 'picture-frame' }, this.#note);
    this.main = h('div', { class: 'stage crowd' }, frame);
    this.panel = h('div', { class: 'panel-body' },
      section('This frame', true, this.#readout.element),
      section('Crowd', true, count.element, detail.element, this.#tolerance.element, this.#budget.element, tiers.element, this.#tiers),
      section('Importance', true, this.#picked, this.#importance.element, button('Back to all equal', () => this.#forget(), 'small')));
    this.#showFields();
    studio.addEventListener('state', () => this.#follow());
    studio.addEventListener('character', () => void this.#renew());
    viewport.renderer.domElement.addEventListener('click', (event) => this.#pick(event));
  }

  mount(): void {
    this.#viewport.showIn(this.main, (dt) => this.#frame(dt));
    void this.#renew();
  }

  unmount(): void {
    this.#clear();
  }

  get #isShown(): boolean {
    return this.#viewport.isIn(this.main);
  }

  /** Makes the crowd anew; a file without tables is prepared first. */
  async #renew(): Promise<void> {
    if (!this.#isShown) {
      return;
    }
    this.#clear();
    this.#frames = 0;
    if (!this.#studio.character.asset.core.isPrepared) {
      this.#note.textContent = 'A crowd needs the tables of the file, which are being made.';
      this.#note.hidden = false;
      try {
        await this.#studio.prepared();
      } catch (error) {
        this.#studio.notices.fault(error);
      }
      return;
    }
    this.#note.hidden = true;
    const { asset } = this.#studio.character;
    const { count } = this.#studio.state;
    try {
      this.crowd = new ArticulaCrowd(asset, count);
    } catch (error) {
      this.#studio.notices.fault(error);
      return;
    }
    const side = Math.ceil(Math.sqrt(count));
    for (let i = 0; i < count; i += 1) {
      const [column, row] = [i % side, Math.floor(i / side)];
      this.crowd.place(i, (column - (side - 1) / 2) * SPACING + wobble(i), 0, -row * SPACING + wobble(i + 7), wobble(3 * i));
      if (asset.clips.length > 0) {
        this.crowd.play(i, asset.clips[(i * 7) % asset.clips.length] ?? '', (i * 0.37) % 5);
      }
    }
    this.#viewport.scene.add(this.crowd);
    this.#detail();
    const height = heightOf(asset);
    this.#viewport.leave();
    const back = Math.min(side, 12) * 0.6 + 2;
    this.#viewport.controls.target.set(0, height * 0.35, -back * 0.4);
    this.#viewport.camera.position.set(back * 0.15, height * (0.9 + 0.12 * back), back);
    this.#viewport.controls.update();
    this.#viewport.step(0);
  }

  #clear(): void {
    this.crowd?.dispose();
    this.crowd = undefined;
    this.#chosen = -1;
  }

  #follow(): void {
    const { state } = this.#studio;
    const before = this.#before;
    this.#before = { ...state };
    this.#showFields();
    if (!this.#isShown || this.crowd === undefined) {
      return;
    }
    if (state.count !== before.count) {
      void this.#renew();
    } else if (state.detail !== before.detail || state.tolerance !== before.tolerance || state.budget !== before.budget) {
      this.#detail();
    }
    if (!state.tiers && before.tiers) {
      for (let i = 0; i < state.count; i += 1) {
        this.crowd.setColorAt(i, WHITE);
      }
    }
  }

  #showFields(): void {
    this.#tolerance.element.hidden = this.#studio.state.detail !== 'tolerance';
    this.#budget.element.hidden = this.#studio.state.detail !== 'budget';
  }

  #detail(): void {
    const { detail, tolerance, budget } = this.#studio.state;
    if (detail === 'tolerance') {
      this.crowd?.setTolerance(tolerance);
    } else if (detail === 'budget') {
      this.crowd?.setBudget(budget);
    } else {
      this.crowd?.setFullDetail();
    }
  }

  #pick(event: MouseEvent): void {
    if (!this.#isShown || this.crowd === undefined) {
      return;
    }
    const box = this.#viewport.renderer.domElement.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.#viewport.camera);
    const hit = ray.intersectObject(this.crowd)[0];
    if (hit?.instanceId !== undefined) {
      this.#chosen = hit.instanceId;
      this.#importance.set(0);
      this.#picked.textContent = `Character ${hit.instanceId + 1}, ${hit.distance.toFixed(1)} m away, at tier ${this.crowd.levelOf(hit.instanceId)}.`;
    }
  }

  #weigh(importance: number): void {
    if (this.#chosen >= 0) {
      this.crowd?.setImportance(this.#chosen, importance);
    }
  }

  #forget(): void {
    for (let i = 0; i < (this.crowd?.count ?? 0); i += 1) {
      this.crowd?.setImportance(i, 1);
    }
    this.#importance.set(0);
  }

  #frame(dtSecs: number): void {
    const { crowd } = this;
    if (crowd === undefined) {
      return;
    }
    const now = performance.now();
    this.#frameMs += (now - this.#last - this.#frameMs) * 0.1;
    this.#last = now;
    crowd.update(dtSecs, this.#viewport.camera, this.#viewport.columnSize);
    if (this.#frames % PAINT_EVERY === 1) {
      this.#paint(crowd);
    }
    this.#frames += 1;
  }

  /** Counts and colours the tiers, and renews the figures. */
  #paint(crowd: ArticulaCrowd): void {
    const counts = new Array<number>(crowd.core.levels).fill(0);
    let visible = 0;
    for (let i = 0; i < crowd.count; i += 1) {
      const level = crowd.levelOf(i);
      if (level >= 0) {
        counts[level] = (counts[level] ?? 0) + 1;
        visible += 1;
        if (this.#studio.state.tiers) {
          crowd.setColorAt(i, tierColor(level));
        }
      }
    }
    const { render } = this.#viewport.renderer.info;
    const tolerance = crowd.core.tolerancePx;
    this.#readout.set('Characters in view', `${visible.toLocaleString('en')} of ${crowd.count.toLocaleString('en')}`);
    this.#readout.set('Error that may show', tolerance === 0 ? 'none' : `${tolerance.toFixed(2)} px`);
    this.#readout.set('Planning and poses', `${crowd.lastFrameMs.toFixed(2)} ms`);
    this.#readout.set('Frame', `${this.#frameMs.toFixed(1)} ms`);
    this.#readout.set('Triangles drawn', render.triangles.toLocaleString('en'));
    this.#readout.set('Draw calls', String(render.calls));
    const most = Math.max(...counts, 1);
    this.#tiers.replaceChildren(...counts.map((count, level) => {
      const bar = h('i', {});
      bar.style.width = `${(100 * count) / most}%`;
      bar.style.background = tierColor(level);
      return h('li', {}, h('span', {}, level === 0 ? 'full' : `tier ${level}`), h('div', { class: 'bar' }, bar), h('b', {}, count.toLocaleString('en')));
    }));
  }
}

function tierColor(level: number): string {
  return TIER_COLORS[Math.min(level, TIER_COLORS.length - 1)] ?? '#888';
}

/** A small number from an index, the same at each visit. */
function wobble(i: number): number {
  return ((Math.imul(i + 1, 0x9e3779b1) >>> 8) / 2 ** 24 - 0.5) * 0.6;
}
