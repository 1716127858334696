import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';
import { section, slider } from '../ui/controls.js';

/** Most figures beside the first that share its geometry. */
export const MOST_CLONES = 8;

/** Where the character stands, and how many stand beside it. */
export function placement(studio: Studio): HTMLElement {
  const { state } = studio;
  const set = (change: Partial<StudioState>): void => studio.set(change);
  const metres = (value: number): string => `${value.toFixed(1)} m`;
  const turn = slider({ label: 'Turned by', min: -180, max: 180, step: 5, value: state.turn, shown: (deg) => `${deg}°`, onInput: (deg) => set({ turn: deg }) });
  const across = slider({ label: 'To the right', min: -5, max: 5, step: 0.1, value: state.across, shown: metres, onInput: (m) => set({ across: m }) });
  const nearer = slider({ label: 'To the front', min: -20, max: 5, step: 0.1, value: state.nearer, shown: metres, onInput: (m) => set({ nearer: m }) });
  const clones = slider({
    label: 'Clones',
    min: 0,
    max: MOST_CLONES,
    step: 1,
    value: state.clones,
    shown: (n) => (n === 0 ? 'none' : `${n}`),
    hint: 'They share geometry and clips, and each has its own joints: the numbers above are those of the first.',
    onInput: (n) => set({ clones: n }),
  });
  return section('Placement', false, turn.element, across.element, nearer.element, clones.element);
}
