/** Longest recording in seconds. */
const MOST_SECS = 120;

/** How expressions are moved by hand, as a capture of a face that becomes a clip. */
export class FaceRecording {
  readonly #rows: { readonly secs: number; readonly weights: ReadonlyMap<string, number> }[] = [];
  #secs = 0;

  /** Takes over the weights after a step of the page's clock; false once it is as long as it may be. */
  take(dtSecs: number, weights: ReadonlyMap<string, number>): boolean {
    this.#secs += this.#rows.length === 0 ? 0 : dtSecs;
    if (dtSecs > 0 || this.#rows.length === 0) {
      this.#rows.push({ secs: this.#secs, weights: new Map(weights) });
    }
    return this.#secs < MOST_SECS;
  }

  /** Number of moments. */
  get length(): number {
    return this.#rows.length;
  }

  /** The capture as CSV in the form of Live Link Face: a time of day, and a column for each expression. */
  csv(): string {
    const names = [...new Set(this.#rows.flatMap(({ weights }) => [...weights.keys()]))];
    const rows = this.#rows.map(({ secs, weights }) => {
      const [minutes, rest] = [Math.floor(secs / 60), (secs % 60).toFixed(4).padStart(7, '0')];
      return [`00:${String(minutes).padStart(2, '0')}:${rest}`, ...names.map((name) => (weights.get(name) ?? 0).toFixed(3))].join(',');
    });
    return [['Timecode', ...names].join(','), ...rows, ''].join('\n');
  }
}
