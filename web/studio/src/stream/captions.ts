/** What is said, or the picture that is shown, from one time of a clip to another. */
export interface Cue {
  /** The clip to whose clock it belongs; any without. */
  readonly clip: string | undefined;
  readonly from: number;
  readonly to: number;
  readonly text: string;
}

/** Reads a WebVTT file as `articula play` does: cues as plain text, each under the name of its clip. Blocks that are no cues are left out. */
export function readCues(vtt: string): readonly Cue[] {
  return vtt.replaceAll(/\r\n?/g, '\n').split('\n\n').flatMap(cueOf);
}

/** The first of the cues at a time within a clip. */
export function cueAt(cues: readonly Cue[], clip: string | undefined, secs: number): Cue | undefined {
  return cues.find((cue) => (cue.clip === undefined || cue.clip === clip) && cue.from <= secs && secs < cue.to);
}

function cueOf(block: string): Cue[] {
  const lines = block.split('\n').filter((line) => line !== '');
  const timing = lines.findIndex((line) => line.includes('-->'));
  const [from, to] = (lines[timing] ?? '').split('-->');
  // Settings of the place follow the second time.
  const times = [secsOf(from?.trim()), secsOf(to?.trim().split(/\s/)[0])];
  const text = lines.slice(timing + 1).map((line) => line.replaceAll(/<[^>]*>/g, '')).join(' ');
  if (times.some((time) => time === undefined)) {
    return [];
  }
  return [{ clip: lines[timing - 1]?.trim(), from: times[0] as number, to: times[1] as number, text }];
}

/** A time as hours (which may be missing), minutes and seconds. */
function secsOf(text: string | undefined): number | undefined {
  const parts = text?.split(':').map((part) => (part === '' ? Number.NaN : Number(part))) ?? [];
  const secs = parts.reduce((sum, part) => 60 * sum + part, 0);
  return parts.length > 0 && parts.every((part) => part >= 0) && Number.isFinite(secs) ? secs : undefined;
}
