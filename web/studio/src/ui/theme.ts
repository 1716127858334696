import { h } from './dom.js';

const CHOICES = ['auto', 'light', 'dark'] as const;
const KEY = 'articula-theme';

/** A button that goes through the themes; the choice is kept in this browser. */
export function themeButton(): HTMLButtonElement {
  let at = Math.max(CHOICES.findIndex((choice) => choice === stored()), 0);
  const button = h('button', { type: 'button', class: 'button quiet theme', onclick: () => {
    at = (at + 1) % CHOICES.length;
    try {
      localStorage.setItem(KEY, CHOICES[at] ?? 'auto');
    } catch {
      // A browser that keeps nothing shows the theme until the page is left.
    }
    paint();
  } });
  const paint = (): void => {
    const choice = CHOICES[at] ?? 'auto';
    if (choice === 'auto') {
      delete document.documentElement.dataset.theme;
    } else {
      document.documentElement.dataset.theme = choice;
    }
    button.textContent = choice === 'auto' ? 'Auto' : choice === 'light' ? 'Light' : 'Dark';
    button.setAttribute('aria-label', `Theme: ${choice}`);
    button.title = `Theme: ${choice}`;
    dispatchEvent(new Event('themechange'));
  };
  paint();
  return button;
}

function stored(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}
