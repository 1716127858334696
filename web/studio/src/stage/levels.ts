import { choice, section, segmented, slider } from '../ui/controls.js';
import { freshId, h } from '../ui/dom.js';
import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';

/** Named levels, from no joint to all. */
export const LEVELS = ['None', 'VeryLow', 'Low', 'Medium', 'High', 'Fingers', 'VeryHigh'] as const;
const ZONES = ['face', 'torso', 'arms', 'hands', 'pelvis', 'legs', 'feet'] as const;
const WORDS: Record<string, string> = { '': 'Not used', VeryLow: 'Very low', VeryHigh: 'Very high' };

/** The name of a level in words. */
export function spoken(level: string): string {
  return WORDS[level] ?? level;
}

const list = (text: string): string[] => text.split(',').filter((word) => word !== '');

/** The profile of the selectors, as `articula` reads and writes it. */
export function profile(state: StudioState): string {
  const zones = list(state.zones);
  return JSON.stringify(
    {
      manual: state.metric === 'none',
      rule: state.rule,
      ...(state.depth > 0 && { depth: state.depth }),
      ...(state.complexity !== '' && { complexity: state.complexity }),
      ...(state.hanim !== '' && { hanim: Number(state.hanim) }),
      ...(zones.length > 0 && { zones }),
      joints: { plus: list(state.plus), minus: list(state.minus) },
    },
    null,
    2,
  );
}

/** Joints that the selectors or the expression choose. */
export function chosenJoints(studio: Studio): Uint32Array {
  const { core } = studio.character.asset;
  const { expression } = studio.state;
  return expression === '' ? core.jointsOfProfile(profile(studio.state)) : core.jointsOfExpression(expression);
}

/** The selectors of a level of articulation: level, depth, zones, joints, or an expression. */
export class LevelsPanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #count = h('p', { class: 'said', role: 'status' });
  readonly #joints = h('div', { class: 'joint-list', role: 'group', 'aria-label': 'Single joints' });
  readonly #expression: HTMLInputElement;
  readonly #fault = h('p', { class: 'field-fault', role: 'alert', hidden: true });
  readonly #search: HTMLInputElement;
  readonly #shows: (() => void)[] = [];

  constructor(studio: Studio) {
    this.#studio = studio;
    const { state } = studio;
    const position = (word: string): number => LEVELS.findIndex((level) => level === word) + 1;
    const level = slider({
      label: 'Level of articulation',
      min: 0,
      max: LEVELS.length,
      step: 1,
      value: position(state.complexity),
      shown: (i) => spoken(LEVELS[i - 1] ?? ''),
      onInput: (i) => this.#set({ complexity: LEVELS[i - 1] ?? '' }),
    });
    const depth = slider({
      label: 'Depth below the root',
      min: 0,
      max: 20,
      step: 1,
      value: state.depth,
      shown: (k) => (k === 0 ? 'Not used' : `${k}`),
      onInput: (k) => this.#set({ depth: k }),
    });
    const hanim = choice('H-Anim level', [['', 'Not used'], ['0', 'LOA-0'], ['1', 'LOA-1'], ['2', 'LOA-2'], ['3', 'LOA-3']], state.hanim, (word) => this.#set({ hanim: word }));
    const rule = segmented('Selectors combine by', [['sum', 'Sum'], ['restrict', 'Intersection']], state.rule, (word) => this.#set({ rule: word as StudioState['rule'] }));
    const zones = this.#zones();
    const [searchId, exprId] = [freshId(), freshId()];
    this.#search = h('input', { id: searchId, type: 'search', placeholder: 'Find a joint', oninput: () => this.#fillJoints() });
    this.#expression = h('input', { id: exprId, type: 'text', spellcheck: 'false', autocomplete: 'off', placeholder: 'loa(Low) + zone(hands)', oninput: () => this.#express() });
    this.#expression.value = state.expression;
    const joints = h('details', { class: 'fold' }, h('summary', {}, 'Single joints'), h('label', { for: searchId, class: 'hidden' }, 'Find a joint'), this.#search, this.#joints);
    const written = h('div', { class: 'field' }, h('label', { for: exprId }, 'Expression, in place of the selectors'), this.#expression, this.#fault);
    this.element = section('Level of articulation', true, level.element, depth.element, zones, hanim.element, rule.element, joints, written, this.#count);
    this.element.id = 'levels';
    this.#shows.push(
      () => level.set(position(studio.state.complexity)),
      () => depth.set(studio.state.depth),
      () => hanim.set(studio.state.hanim),
      () => rule.set(studio.state.rule),
    );
  }

  /** Shows another character, or a state that came from elsewhere. */
  renew(): void {
    this.#shows.forEach((show) => show());
    this.#expression.value = this.#studio.state.expression;
    this.#fillJoints();
  }

  /** Says how many joints are chosen, or what is wrong with them. */
  say(chosen: number | Error): void {
    const all = this.#studio.character.asset.joints.length;
    const fault = chosen instanceof Error;
    this.#fault.hidden = !fault;
    this.#fault.textContent = fault ? chosen.message : '';
    this.#expression.setAttribute('aria-invalid', String(fault));
    this.#count.textContent = fault ? 'The joints chosen before stay.' : `${chosen} of ${all} joints may move.`;
  }

  #set(change: Partial<StudioState>): void {
    this.#expression.value = '';
    this.#studio.set({ expression: '', ...change });
  }

  #express(): void {
    this.#studio.set({ expression: this.#expression.value.trim() });
  }

  #zones(): HTMLElement {
    const boxes = ZONES.map((zone) => {
      const id = freshId();
      const box = h('input', { id, type: 'checkbox', value: zone });
      this.#shows.push(() => {
        box.checked = list(this.#studio.state.zones).includes(zone);
      });
      box.checked = list(this.#studio.state.zones).includes(zone);
      return { box, parts: [box, h('label', { for: id }, zone)] };
    });
    const change = (): void => this.#set({ zones: boxes.filter(({ box }) => box.checked).map(({ box }) => box.value).join(',') });
    return h('fieldset', { class: 'chips', onchange: change }, h('legend', {}, 'Zones'), h('div', {}, ...boxes.flatMap(({ parts }) => parts)));
  }

  #fillJoints(): void {
    const { asset } = this.#studio.character;
    const wanted = this.#search.value.toLowerCase();
    const [plus, minus] = [list(this.#studio.state.plus), list(this.#studio.state.minus)];
    const regions = asset.core.jointRegions;
    const rows = asset.joints.map((name, joint) => {
      if (!name.toLowerCase().includes(wanted)) {
        return undefined;
      }
      const id = freshId();
      const select = h('select', { id, onchange: () => this.#override(name, select.value) }, h('option', { value: '' }, 'as selected'), h('option', { value: 'plus' }, 'always'), h('option', { value: 'minus' }, 'never'));
      select.value = plus.includes(name) ? 'plus' : minus.includes(name) ? 'minus' : '';
      return h('div', { class: 'joint' }, h('label', { for: id }, name, h('small', {}, regions[joint] ?? '')), select);
    });
    this.#joints.replaceChildren(...rows.filter((row) => row !== undefined));
  }

  #override(name: string, word: string): void {
    const without = (text: string): string[] => list(text).filter((other) => other !== name);
    const [plus, minus] = [without(this.#studio.state.plus), without(this.#studio.state.minus)];
    (word === 'plus' ? plus : word === 'minus' ? minus : []).push(name);
    this.#set({ plus: plus.join(','), minus: minus.join(',') });
  }
}
