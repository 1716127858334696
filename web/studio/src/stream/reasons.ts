import type { StreamReport } from '@articula/three';

import type { StudioState } from '../state.js';

/** What bounds what is shown, in words. */
export function reasonOf(report: StreamReport, { by, kbps, memory, wanted }: StudioState): string {
  const { level, levels, target } = report;
  const decides = by === 'session' ? 'the server' : 'this page';
  const rate = kbps > 0 ? `${kbps.toLocaleString('en')} kbit/s` : 'the rate that was measured';
  if (level === 0) {
    return 'The least that can be shown is on its way.';
  }
  if (target < levels) {
    return `${rate} carries level ${target} of this motion and not level ${target + 1}, so ${decides} keeps to it.`;
  }
  if (level < target) {
    return `${rate} carries level ${target}; its bytes are on their way.`;
  }
  const bounds = `${wanted} px at this distance${memory > 0 ? ` in ${memory} MB` : ''}`;
  return report.isComplete
    ? `All that ${bounds} asks for is here; finer parts are left out.`
    : `What plays is as fine as ${bounds} asks for; the rest of it is on its way.`;
}

/** What the page tells whoever decides, for the log. */
export function contextOf({ kbps, memory, wanted }: StudioState): string {
  const rate = kbps > 0 ? `${kbps.toLocaleString('en')} kbit/s` : 'any rate';
  return `context: ${rate}, ${wanted} px, ${memory > 0 ? `${memory} MB` : 'any memory'}`;
}
