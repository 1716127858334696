import type { PackagedBytes } from '@articula/core';

import { h } from '../ui/dom.js';
import type { Background } from './background.js';
import type { Preview } from './preview.js';

/** The report of `articula flatten --profile portrait --json`, as far as it is shown. */
export interface PortraitReport {
  readonly profile: 'portrait';
  readonly bytes: { readonly raw: number; readonly gzip: number; readonly brotli: number };
  readonly views: number;
  readonly triangles: number;
  readonly expressions: number;
  readonly frames: number;
  readonly error: readonly { readonly yaw_deg: number; readonly image_rmse_levels: number }[];
  readonly warnings: readonly string[];
}

/** The player of a portrait, as far as it is used. */
interface Player {
  readonly frames: number;
  play(clip: number): Promise<void>;
  pose(head: { readonly yaw: number }): void;
  stop(): void;
}

interface PlayerModule {
  readonly ArticulaPortrait: new (canvas: HTMLCanvasElement, json: unknown, images: readonly HTMLImageElement[], options: { readonly scale: number }) => Player;
}

/** A portrait that is shown. */
export interface PortraitPreview extends Preview {
  readonly face: Player;
  /** Turns the head by degrees and holds it there; straight on, it plays. */
  turn(degrees: number): void;
}

/** Pixels of the canvas in one of the document. */
const SCALE = 2;

/** Shows a portrait by the player and the pictures that are among its files. */
export async function showPortrait(into: HTMLElement, files: readonly PackagedBytes[]): Promise<PortraitPreview> {
  const json = JSON.parse(text(files, 'portrait.json')) as { readonly clips: readonly unknown[]; readonly views: readonly { readonly picture: string }[] };
  const images = await Promise.all(json.views.map(({ picture }) => pictureOf(bytesOf(files, picture))));
  // The player is a script for any page; as a module it leaves nothing behind.
  const url = URL.createObjectURL(new Blob([text(files, 'player.js'), '\nexport { ArticulaPortrait };\n'], { type: 'text/javascript' }));
  const { ArticulaPortrait } = (await import(/* @vite-ignore */ url)) as PlayerModule;
  URL.revokeObjectURL(url);
  const canvas = h('canvas', { 'aria-label': 'The head as a portrait', role: 'img' });
  into.replaceChildren(canvas);
  const face = new ArticulaPortrait(canvas, json, images, { scale: SCALE });
  const turn = (degrees: number): void => {
    face.stop();
    if (degrees === 0 && json.clips.length > 0) {
      void face.play(0);
    } else {
      face.pose({ yaw: degrees });
    }
  };
  turn(0);
  return { face, turn, end: () => face.stop() };
}

/** The page of a portrait with a picture behind the head, cut to the square that it fills. */
export async function portraitWithBackground(page: Uint8Array, background: Background): Promise<Uint8Array> {
  const image = await pictureOf(background.bytes);
  const side = Math.min(image.naturalWidth, image.naturalHeight);
  const canvas = h('canvas', { width: side, height: side });
  canvas.getContext('2d')?.drawImage(image, (side - image.naturalWidth) / 2, (side - image.naturalHeight) / 2);
  const [html, none] = [new TextDecoder().decode(page), 'const behind = null;'];
  if (!html.includes(none)) {
    throw new Error('the page of the portrait has no place for a background');
  }
  return new TextEncoder().encode(html.replace(none, `const behind = ${JSON.stringify(canvas.toDataURL('image/png'))};`));
}

async function pictureOf(bytes: Uint8Array): Promise<HTMLImageElement> {
  const image = new Image();
  image.src = URL.createObjectURL(new Blob([bytes as BlobPart]));
  try {
    await image.decode();
  } finally {
    URL.revokeObjectURL(image.src);
  }
  return image;
}

function bytesOf(files: readonly PackagedBytes[], name: string): Uint8Array {
  const found = files.find((file) => file.name === name);
  if (found === undefined) {
    throw new Error(`the portrait has no ${name}`);
  }
  return found.bytes;
}

function text(files: readonly PackagedBytes[], name: string): string {
  return new TextDecoder().decode(bytesOf(files, name));
}
