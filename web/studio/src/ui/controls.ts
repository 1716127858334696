import { freshId, h } from './dom.js';

/** A control with its label; `set` shows a value without telling it. */
export interface Control<T> {
  readonly element: HTMLElement;
  set(value: T): void;
}

export interface SliderOptions {
  readonly label: string;
  readonly min: number;
  readonly max: number;
  readonly step: number;
  readonly value: number;
  readonly hint?: string;
  /** The value in words, with its unit. */
  readonly shown: (value: number) => string;
  readonly onInput: (value: number) => void;
}

export function slider(options: SliderOptions): Control<number> {
  const id = freshId();
  const { min, max, step, value } = options;
  const output = h('output', { for: id, class: 'value' }, options.shown(value));
  const input = h('input', { id, type: 'range', min, max, step });
  input.value = String(value);
  const show = (): void => {
    const shown = options.shown(input.valueAsNumber);
    output.textContent = shown;
    input.setAttribute('aria-valuetext', shown);
  };
  show();
  input.addEventListener('input', () => {
    show();
    options.onInput(input.valueAsNumber);
  });
  const head = h('div', { class: 'field-head' }, h('label', { for: id }, options.label), output);
  return {
    element: h('div', { class: 'field' }, head, input, options.hint && h('p', { class: 'hint' }, options.hint)),
    set(next) {
      input.value = String(next);
      show();
    },
  };
}

/** A choice among words; each has a value and what is shown. */
export function choice(
  label: string,
  choices: readonly (readonly [string, string])[],
  value: string,
  onChange: (value: string) => void,
): Control<string> & { fill(choices: readonly (readonly [string, string])[]): void } {
  const id = freshId();
  const select = h('select', { id });
  const fill = (all: readonly (readonly [string, string])[]): void => {
    const kept = select.value;
    select.replaceChildren(...all.map(([key, text]) => h('option', { value: key }, text)));
    select.disabled = all.length === 0;
    if (all.length === 0) {
      select.append(h('option', { value: '' }, 'none yet'));
    }
    if (all.some(([key]) => key === kept)) {
      select.value = kept;
    }
  };
  fill(choices);
  select.value = value;
  select.addEventListener('change', () => onChange(select.value));
  return {
    element: h('div', { class: 'field row' }, h('label', { for: id }, label), select),
    set(next) {
      select.value = next;
    },
    fill,
  };
}

/** Buttons of which one is pressed. */
export function segmented(
  label: string,
  choices: readonly (readonly [string, string])[],
  value: string,
  onChange: (value: string) => void,
): Control<string> {
  const name = freshId();
  const inputs = choices.map(([key, text]) => {
    const id = freshId();
    const input = h('input', { id, type: 'radio', name, value: key });
    input.checked = key === value;
    input.addEventListener('change', () => onChange(key));
    return { input, key, parts: [input, h('label', { for: id }, text)] };
  });
  const legend = h('legend', {}, label);
  return {
    element: h('fieldset', { class: 'segmented' }, legend, h('div', {}, ...inputs.flatMap(({ parts }) => parts))),
    set(next) {
      for (const { input, key } of inputs) {
        input.checked = key === next;
      }
    },
  };
}

export function toggle(label: string, value: boolean, onChange: (value: boolean) => void): Control<boolean> {
  const id = freshId();
  const input = h('input', { id, type: 'checkbox' });
  input.checked = value;
  input.addEventListener('change', () => onChange(input.checked));
  return {
    element: h('div', { class: 'toggle' }, input, h('label', { for: id }, label)),
    set(next) {
      input.checked = next;
    },
  };
}

/** A choice of a colour, as #rrggbb. */
export function color(label: string, value: string, onInput: (value: string) => void): Control<string> {
  const id = freshId();
  const input = h('input', { id, type: 'color' });
  input.value = value;
  input.addEventListener('input', () => onInput(input.value));
  return {
    element: h('div', { class: 'field row' }, h('label', { for: id }, label), input),
    set(next) {
      input.value = next;
    },
  };
}

/** A part of a panel with a heading that folds. */
export function section(title: string, open: boolean, ...children: readonly (Node | string)[]): HTMLDetailsElement {
  return h('details', { class: 'section', open }, h('summary', {}, h('h2', {}, title)), h('div', { class: 'section-body' }, ...children));
}

export function button(text: string, onClick: () => void, kind = ''): HTMLButtonElement {
  return h('button', { type: 'button', class: `button ${kind}`, onclick: onClick }, text);
}
