import { h } from '../ui/dom.js';

/** A picture that is shown, until it is ended. */
export interface Preview {
  end(): void;
}

/** Shows a picture of a form, from its file. */
export async function preview(into: HTMLElement, form: 'svg' | 'player' | 'lottie', bytes: Uint8Array): Promise<Preview> {
  switch (form) {
    case 'svg':
      return showSvg(into, bytes);
    case 'player':
      return showPlayer(into, bytes);
    case 'lottie':
      return showLottie(into, bytes);
  }
}

function showSvg(into: HTMLElement, bytes: Uint8Array): Preview {
  const url = URL.createObjectURL(new Blob([bytes as BlobPart], { type: 'image/svg+xml' }));
  into.replaceChildren(h('img', { src: url, alt: 'The clip as an animated SVG' }));
  return { end: () => URL.revokeObjectURL(url) };
}

/** What a player's module exports. */
interface PlayerModule {
  readonly mount: (canvas: HTMLCanvasElement) => Promise<unknown>;
}

async function showPlayer(into: HTMLElement, bytes: Uint8Array): Promise<Preview> {
  const url = URL.createObjectURL(new Blob([bytes as BlobPart], { type: 'text/javascript' }));
  const canvas = h('canvas', { 'aria-label': 'The clip, drawn by the player', role: 'img' });
  into.replaceChildren(canvas);
  const module = (await import(/* @vite-ignore */ url)) as PlayerModule;
  URL.revokeObjectURL(url);
  await module.mount(canvas);
  return { end: () => canvas.remove() };
}

async function showLottie(into: HTMLElement, bytes: Uint8Array): Promise<Preview> {
  const { default: lottie } = await import('lottie-web/build/player/lottie_light');
  const box = h('div', { class: 'lottie', role: 'img', 'aria-label': 'The clip as Lottie' });
  into.replaceChildren(box);
  const animationData: unknown = JSON.parse(new TextDecoder().decode(bytes));
  const animation = lottie.loadAnimation({ container: box, renderer: 'svg', loop: true, autoplay: true, animationData });
  return { end: () => animation.destroy() };
}
