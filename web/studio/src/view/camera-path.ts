/** Where a camera is at a time: seconds of the clip, and metres in the space of the character. */
export interface CameraKey {
  readonly t: number;
  readonly eye: Point;
  readonly target: Point;
}

export type Point = readonly [number, number, number];

/** Where the camera of a recording began, in the space of the figure; the clip is told as if the figure had moved before it. */
export interface RecordedCamera {
  readonly eye: Point;
  readonly target: Point;
  readonly fovDeg: number;
  /** The same in the space of the page, where the clip is played. */
  readonly pose: string;
}

/** Metres by which a path may change when keys are left out. */
const LEAST_METRES = 0.001;
/** Digits of a written number: tenths of a millimetre. */
const DIGITS = 4;

/** Reads the file that `articula lod --camera-path` reads. Throws an error that names the place. */
export function readCameraPath(text: string): readonly CameraKey[] {
  const read: unknown = JSON.parse(text);
  if (!Array.isArray(read) || read.length === 0) {
    throw new Error('a camera path is a list of {"t", "eye": [x, y, z], "target": [x, y, z]}, at least one');
  }
  const keys = read.map((key: unknown, i) => keyOf(key, `[${i}]`));
  keys.forEach(({ t }, i) => {
    if (t < (keys[i - 1]?.t ?? -Infinity)) {
      throw new Error(`[${i}].t: ${t} comes after a later time; sort the keys by time`);
    }
  });
  return keys;
}

/** Writes a file that {@link readCameraPath} and the program read. */
export function writeCameraPath(keys: readonly CameraKey[]): string {
  const lines = keys.map((key) => `  ${JSON.stringify(key, (_, value: unknown) => (typeof value === 'number' ? Number(value.toFixed(DIGITS)) : value))}`);
  return `[\n${lines.join(',\n')}\n]\n`;
}

/** The camera at a time, between the keys around it; before the first and after the last it stands. */
export function cameraAt(keys: readonly CameraKey[], secs: number): CameraKey | undefined {
  const next = keys.findIndex(({ t }) => t > secs);
  const [a, b] = [keys[next < 0 ? keys.length - 1 : next - 1], keys[next]];
  return a === undefined || b === undefined ? (a ?? b) : between(a, b, secs);
}

/** Leaves out the keys that those around them give as well. */
export function thinned(keys: readonly CameraKey[]): readonly CameraKey[] {
  const [first, last] = [keys[0], keys.at(-1)];
  if (first === undefined || last === undefined || keys.length < 3) {
    return keys;
  }
  const off = keys.map((key) => distance(between(first, last, key.t), key));
  const worst = off.indexOf(Math.max(...off));
  if ((off[worst] ?? 0) <= LEAST_METRES) {
    return [first, last];
  }
  // The ends are exact, so the worst key is between them.
  return [...thinned(keys.slice(0, worst + 1)).slice(0, -1), ...thinned(keys.slice(worst))];
}

function between(a: CameraKey, b: CameraKey, secs: number): CameraKey {
  const share = b.t > a.t ? (secs - a.t) / (b.t - a.t) : 0;
  const mix = (from: Point, to: Point): Point => [0, 1, 2].map((i) => at(from, i) + share * (at(to, i) - at(from, i))) as unknown as Point;
  return { t: secs, eye: mix(a.eye, b.eye), target: mix(a.target, b.target) };
}

function distance(a: CameraKey, b: CameraKey): number {
  const of = (from: Point, to: Point): number => Math.hypot(...[0, 1, 2].map((i) => at(from, i) - at(to, i)));
  return Math.max(of(a.eye, b.eye), of(a.target, b.target));
}

function at(point: Point, i: number): number {
  return point[i] ?? 0;
}

function keyOf(key: unknown, place: string): CameraKey {
  const { t, eye, target } = (key ?? {}) as Record<string, unknown>;
  if (typeof t !== 'number' || !Number.isFinite(t)) {
    throw new Error(`${place}.t: give seconds`);
  }
  const points = [pointOf(eye, `${place}.eye`), pointOf(target, `${place}.target`)] as const;
  if (points[0].join() === points[1].join()) {
    throw new Error(`${place}: eye and target are the same point; move the target to the subject`);
  }
  return { t, eye: points[0], target: points[1] };
}

function pointOf(point: unknown, place: string): Point {
  if (!Array.isArray(point) || point.length !== 3 || !point.every((x) => typeof x === 'number' && Number.isFinite(x))) {
    throw new Error(`${place}: give [x, y, z] in metres`);
  }
  return point as unknown as Point;
}
