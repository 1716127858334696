/** What a permalink holds. Only values that differ from these are written. */
export interface StudioState {
  page: 'stage' | 'crowd' | 'flat' | 'lighter' | 'stream' | 'devices';
  clip: string;
  /** Whether choosing a clip makes its joints the active ones. */
  own: boolean;
  /** Whether motions that are taken home are of the active joints alone. */
  alone: boolean;
  /** Time of the clip in seconds, where it is paused. */
  at: number;
  playing: boolean;
  loop: boolean;
  speed: number;
  columns: 'one' | 'two' | 'levels';
  body: 'solid' | 'clear' | 'none';
  skeleton: boolean;
  radius: number;
  /** Colours of joints by their states, as #rrggbb. */
  activeColor: string;
  passiveColor: string;
  changingColor: string;
  /** Degrees by which the character is turned, and metres by which it stands aside. */
  turn: number;
  across: number;
  nearer: number;
  /** Whether dragging the picture moves the character in place of the camera. */
  drag: boolean;
  /** Figures beside the first. */
  clones: number;
  /** Where the camera of the stage is and looks, six numbers with commas between them; as it fits without. */
  camera: string;
  complexity: string;
  depth: number;
  hanim: string;
  zones: string;
  rule: 'sum' | 'restrict';
  plus: string;
  minus: string;
  expression: string;
  metric: 'none' | 'pixels' | 'thesis';
  pixels: number;
  threshold: number;
  farthest: number;
  curve: 'literal' | 'fixed';
  /** Weight of orientation against velocity in the errors of thresholds. */
  beta: number;
  lookup: number;
  transition: number;
  ease: 'smooth' | 'linear';
  passive: 'hold' | 'rest';
  count: number;
  detail: 'tolerance' | 'budget' | 'full';
  tolerance: number;
  budget: number;
  tiers: boolean;
  form: 'svg' | 'player' | 'lottie' | 'portrait';
  triangles: number;
  yaw: number;
  /** Error in pixels that a lighter file may have. */
  lost: number;
  compress: 'ext' | 'khr' | 'quantize' | 'none';
  keys: boolean;
  /** Whether all triangles, and the pictures, stay. */
  fine: boolean;
  pictures: boolean;
  attributes: boolean;
  /** Most seconds of frames of a benchmark. */
  seconds: number;
  /** Name of a character of the server; the first without. */
  character: string;
  by: 'http' | 'session';
  /** Kilobits per second; 0 for as many as come. */
  kbps: number;
  /** The same of a second session beside the first; 0 for none. */
  beside: number;
  /** Error in pixels that the viewer tolerates. */
  wanted: number;
  /** Megabytes that the decoded character may take; 0 for any. */
  memory: number;
  /** How the encoder writes a stream: within an error, or in steps. */
  coding: 'tolerance' | 'quantizer';
  /** Greatest error of its finest layer in millimetres, and its layers. */
  mm: number;
  layers: number;
  /** What joints have in common that are cut together. */
  cut: 'region' | 'loa' | 'joint';
  quantizer: number;
  power: number;
  /** Frames that are left out between two coded ones. */
  skipped: number;
}

export const USUAL: Readonly<StudioState> = {
  page: 'stage',
  clip: 'walk',
  own: false,
  alone: false,
  at: 0,
  playing: true,
  loop: true,
  speed: 1,
  columns: 'one',
  body: 'clear',
  skeleton: true,
  radius: 1,
  activeColor: '#1fae57',
  passiveColor: '#d6393d',
  changingColor: '#f2a60d',
  turn: 0,
  across: 0,
  nearer: 0,
  drag: false,
  clones: 0,
  camera: '',
  complexity: '',
  depth: 0,
  hanim: '',
  zones: '',
  rule: 'sum',
  plus: '',
  minus: '',
  expression: '',
  metric: 'none',
  pixels: 1,
  threshold: 1e-4,
  farthest: 1e-3,
  curve: 'literal',
  beta: 0.5,
  lookup: 1,
  transition: 0.2,
  ease: 'smooth',
  passive: 'hold',
  count: 1000,
  detail: 'tolerance',
  tolerance: 1,
  budget: 1,
  tiers: true,
  form: 'svg',
  triangles: 0,
  yaw: 0,
  lost: 1,
  compress: 'ext',
  keys: false,
  fine: false,
  pictures: false,
  attributes: false,
  seconds: 5,
  character: '',
  by: 'session',
  kbps: 0,
  beside: 0,
  wanted: 0.5,
  memory: 0,
  coding: 'tolerance',
  mm: 0.1,
  layers: 5,
  cut: 'region',
  quantizer: 1,
  power: 0,
  skipped: 0,
};

/** Words that the fields of a few known words may have. */
const WORDS: Partial<Record<keyof StudioState, readonly string[]>> = {
  page: ['stage', 'crowd', 'flat', 'lighter', 'stream', 'devices'],
  columns: ['one', 'two', 'levels'],
  body: ['solid', 'clear', 'none'],
  rule: ['sum', 'restrict'],
  metric: ['none', 'pixels', 'thesis'],
  curve: ['literal', 'fixed'],
  ease: ['smooth', 'linear'],
  passive: ['hold', 'rest'],
  detail: ['tolerance', 'budget', 'full'],
  form: ['svg', 'player', 'lottie', 'portrait'],
  compress: ['ext', 'khr', 'quantize', 'none'],
  by: ['http', 'session'],
  coding: ['tolerance', 'quantizer'],
  cut: ['region', 'loa', 'joint'],
};

/** What the colours look like. */
const COLOR = /^#[0-9a-f]{6}$/i;

/** Ranges of the numbers; others are at least 0. */
const RANGES: Partial<Record<keyof StudioState, readonly [number, number]>> = {
  count: [1, 10_000],
  triangles: [0, 20_000],
  yaw: [-180, 180],
  speed: [0.1, 2],
  radius: [0.3, 3],
  turn: [-180, 180],
  across: [-5, 5],
  nearer: [-20, 5],
  clones: [0, 8],
  beta: [0, 1],
  lookup: [1, 60],
  pixels: [0.05, 64],
  tolerance: [0.1, 32],
  budget: [0.02, 16],
  lost: [0.05, 16],
  seconds: [1, 60],
  kbps: [0, 100_000],
  beside: [0, 100_000],
  wanted: [0, 16],
  memory: [0, 4096],
  mm: [0.01, 10],
  layers: [1, 8],
  quantizer: [1, 31],
  power: [0, 7],
  skipped: [0, 31],
};

/** Reads a fragment such as `#stage?clip=walk&complexity=Low`; what it does not know is left out. */
export function readState(fragment: string): StudioState {
  const [page = '', query = ''] = fragment.replace(/^#/, '').split('?');
  const state = { ...USUAL } as Record<string, unknown>;
  const given = new URLSearchParams(query);
  if (WORDS.page?.includes(page)) {
    state.page = page;
  }
  for (const [key, usual] of Object.entries(USUAL)) {
    const text = given.get(key);
    if (text === null || key === 'page') {
      continue;
    }
    const words = WORDS[key as keyof StudioState];
    if (typeof usual === 'number') {
      const [least, most] = RANGES[key as keyof StudioState] ?? [0, 1e6];
      const value = Number(text);
      state[key] = Number.isFinite(value) ? Math.min(Math.max(value, least), most) : usual;
    } else if (typeof usual === 'boolean') {
      state[key] = text === '1';
    } else if (key.endsWith('Color') ? COLOR.test(text) : words === undefined || words.includes(text)) {
      state[key] = text;
    }
  }
  return state as unknown as StudioState;
}

/** Writes a fragment that {@link readState} reads. */
export function writeState(state: StudioState): string {
  const query = new URLSearchParams();
  for (const [key, usual] of Object.entries(USUAL)) {
    const value = state[key as keyof StudioState];
    if (key !== 'page' && value !== usual) {
      query.set(key, typeof value === 'boolean' ? (value ? '1' : '0') : String(value));
    }
  }
  const text = query.toString();
  return `#${state.page}${text === '' ? '' : `?${text}`}`;
}
