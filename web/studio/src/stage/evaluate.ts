import { button, choice, section, slider } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import { USUAL } from '../state.js';
import type { Studio } from '../studio.js';
import { TaskLine } from '../ui/status.js';

interface ErrorPx {
  readonly p50: number;
  readonly p95: number;
  readonly max: number;
}

/** A row of `articula lod --json`, as far as it is shown. */
interface Row {
  readonly method: string;
  readonly variant?: string;
  readonly level?: string;
  readonly distance_m: number;
  readonly joint_update_gain: number;
  readonly parameter: number;
  readonly error_px: ErrorPx;
  readonly joints_sampled: number;
}

const METHODS = [
  ['skin-px', 'Pixel error: joints held'],
  ['skin-px-tables', 'Pixel error: stored keys'],
  ['thesis', 'Threshold on the error matrix'],
  ['ahn', 'Joint posture clusters'],
  ['pc', 'Principal components'],
  ['skip-hold', 'Frames skipped, held'],
  ['skip-lerp', 'Frames skipped, blended'],
  ['loa', 'Levels of articulation'],
  ['chosen', 'The joints chosen above'],
  ['all', 'All methods'],
] as const;

/** The evaluation of `articula lod` on this file, in a worker. */
export class EvaluatePanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #task = new TaskLine();
  readonly #out = h('div', { class: 'results', 'aria-live': 'polite' });
  readonly #expression: () => string;
  #method = 'skin-px';
  #px = 1;

  /** `expression` is that of the joints chosen now. */
  constructor(studio: Studio, expression: () => string) {
    this.#studio = studio;
    this.#expression = expression;
    const method = choice('Method', METHODS, this.#method, (word) => {
      this.#method = word;
    });
    const px = slider({
      label: 'Calibrated to an error of',
      min: 0,
      max: 4,
      step: 0.25,
      value: this.#px,
      shown: (value) => (value === 0 ? 'usual parameters' : `${value} px`),
      onInput: (value) => {
        this.#px = value;
      },
    });
    const about = h('p', { class: 'hint' }, 'Plays the whole clip with and without all joints, at five distances, and measures the skin. The numbers are those of the command articula lod.');
    const run = button('Evaluate', () => void this.run(), 'primary');
    this.element = section('Evaluate', false, about, method.element, px.element, run, this.#task.element, this.#out);
    this.element.id = 'evaluate';
  }

  async run(): Promise<void> {
    const { bytes, name, asset } = this.#studio.character;
    const { state } = this.#studio;
    if (asset.clips.length === 0) {
      this.#out.replaceChildren(h('p', { class: 'hint' }, 'The file has no clip to evaluate.'));
      return;
    }
    const chosen = this.#method === 'chosen';
    try {
      const found = await this.#task.run('Evaluating', (watch) =>
        this.#studio.articula.tools.evaluate(bytes, name, {
          ...(asset.clips.includes(state.clip) && { clip: state.clip }),
          ...(chosen ? { loa: this.#expression() } : { method: this.#method }),
          ...(this.#px > 0 && { calibratePx: this.#px }),
          ...(state.beta !== USUAL.beta && { beta: state.beta }),
          ...watch,
        }),
      );
      this.#show(found as { clip: string; frames: number; rows: Row[] });
    } catch (error) {
      this.#studio.notices.fault(error);
    }
  }

  #show({ clip, frames, rows }: { clip: string; frames: number; rows: Row[] }): void {
    const cell = (text: string, kind = 'number'): HTMLElement => h('td', { class: kind }, text);
    const labelled = rows.some(({ method }) => method !== rows[0]?.method) || rows.some(({ level }) => level !== undefined);
    const head = [labelled && 'Method', 'Distance', 'Saved', 'p50', 'p95', 'Max', 'Joints'].filter((text) => text !== false);
    const body = rows.map((row) =>
      h('tr', {},
        labelled && cell(row.level ?? [row.method, row.variant].filter(Boolean).join(' '), ''),
        cell(`${row.distance_m} m`),
        cell(`${(100 * row.joint_update_gain).toFixed(1)} %`),
        cell(row.error_px.p50.toFixed(2)),
        cell(row.error_px.p95.toFixed(2)),
        cell(row.error_px.max.toFixed(2)),
        cell(row.joints_sampled.toFixed(1))),
    );
    const best = rows.reduce((most, row) => (row.joint_update_gain > most.joint_update_gain ? row : most));
    const verdict = `${clip}, ${frames} frames: up to ${(100 * best.joint_update_gain).toFixed(0)} % of the joint updates are saved, at ${best.distance_m} m with ${best.error_px.p95.toFixed(2)} px.`;
    const table = h('table', {}, h('caption', {}, 'Errors in pixels of a picture of 1280 × 720'), h('thead', {}, h('tr', {}, ...head.map((text) => h('th', { scope: 'col' }, text)))), h('tbody', {}, ...body));
    this.#out.dataset.rows = JSON.stringify(rows);
    this.#out.replaceChildren(h('p', { class: 'said' }, verdict), h('div', { class: 'table-scroll', tabindex: 0, role: 'region', 'aria-label': 'Rows of the evaluation' }, table));
  }
}
