import { h, inBytes } from '../ui/dom.js';

/** Bytes of the parts of a file. */
interface Parts {
  readonly json: number;
  readonly keys: number;
  readonly geometry: number;
  readonly morphs: number;
  readonly textures: number;
  readonly other: number;
}

/** The report of `articula optimize --json`, as far as it is shown. */
export interface OptimizeReport {
  readonly bytes_in: number;
  readonly bytes_out: number;
  readonly before: Parts;
  readonly after: Parts;
  readonly triangles_in: number;
  readonly triangles_out: number;
  readonly bound_mm: number;
  readonly error_mm: number;
  readonly clips: readonly {
    readonly clip: string;
    readonly channels_in: number;
    readonly channels_out: number;
    readonly keys_in: number;
    readonly keys_out: number;
    readonly error_mm: number;
  }[];
}

const NAMES: readonly (readonly [keyof Parts, string])[] = [
  ['json', 'Document (JSON)'],
  ['keys', 'Keys'],
  ['geometry', 'Geometry'],
  ['morphs', 'Morph targets'],
  ['textures', 'Textures'],
  ['other', 'Other'],
];

const number = (text: string): HTMLElement => h('td', { class: 'number' }, text);

function table(caption: string, head: readonly string[], rows: readonly HTMLElement[]): HTMLElement {
  const titles = h('tr', {}, ...head.map((text) => h('th', { scope: 'col' }, text)));
  const made = h('table', {}, h('caption', {}, caption), h('thead', {}, titles), h('tbody', {}, ...rows));
  return h('div', { class: 'table-scroll', tabindex: 0, role: 'region', 'aria-label': caption }, made);
}

/** Where the bytes were and are. */
export function partsTable({ before, after }: OptimizeReport): HTMLElement {
  const rows = NAMES.filter(([part]) => before[part] + after[part] > 0).map(([part, name]) =>
    h('tr', {}, h('td', {}, name), number(inBytes(before[part])), number(inBytes(after[part]))),
  );
  return table('Bytes of the parts', ['Part', 'Before', 'After'], rows);
}

/** What became of each clip. */
export function clipsTable({ clips }: OptimizeReport): HTMLElement {
  const rows = clips.map((clip) =>
    h('tr', {},
      h('td', {}, clip.clip),
      number(`${clip.channels_out} of ${clip.channels_in}`),
      number(`${clip.keys_out.toLocaleString('en')} of ${clip.keys_in.toLocaleString('en')}`),
      number(`${clip.error_mm.toFixed(2)} mm`)),
  );
  return table('Clips', ['Clip', 'Channels', 'Keys', 'Error'], rows);
}
