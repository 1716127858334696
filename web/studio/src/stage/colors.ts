import { type StudioState, USUAL } from '../state.js';
import type { Studio } from '../studio.js';
import { button, color } from '../ui/controls.js';
import { h } from '../ui/dom.js';

const STATES = [
  ['activeColor', 'Active joints', '--active'],
  ['passiveColor', 'Passive joints', '--passive'],
  ['changingColor', 'In transition', '--changing'],
] as const;

/** Colours of joints and bones by their states. */
export function colors(studio: Studio): HTMLElement {
  const { state } = studio;
  const all = STATES.map(([key, label]) => color(label, state[key], (value) => studio.set({ [key]: value })));
  const usual = button('Usual colours', () => {
    STATES.forEach(([key], i) => all[i]?.set(USUAL[key]));
    studio.set(Object.fromEntries(STATES.map(([key]) => [key, USUAL[key]])));
  }, 'small');
  return h('details', { class: 'fold' }, h('summary', {}, 'Colours'), h('div', { class: 'stack' }, ...all.map(({ element }) => element), usual));
}

/** Gives the legend the colours of the joints; the usual ones are those of the style sheet. */
export function paintLegend(main: HTMLElement, state: StudioState): void {
  for (const [key, , variable] of STATES) {
    if (state[key] === USUAL[key]) {
      main.style.removeProperty(variable);
    } else {
      main.style.setProperty(variable, state[key]);
    }
  }
}
