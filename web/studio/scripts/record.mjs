// Records the moving picture of the readme: the stage with the reference human, while its level of articulation falls.
// The pages are those of `npm run build`; the clock is the page's own, so that each run gives the same frames.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { browser } from '../../test/browser.mjs';
import { serve } from '../../test/server.mjs';
import { openFile, openStudio, slide } from '../test/page.mjs';

const OUT = fileURLToPath(new URL('../../../docs/pictures/studio.gif', import.meta.url));
const GIFENC = fileURLToPath(new URL('../../node_modules/gifenc/dist/gifenc.esm.js', import.meta.url));
const [WIDTH, HEIGHT] = [960, 640];
const FPS = 12.5;
/** The level of articulation of each part of the picture, as the slider counts, and its seconds. */
const PARTS = [[0, 1.04], [4, 1.04], [3, 1.04], [2, 1.04]];
const COLORS = 255;

/** A character with levels, made by the program. */
function human(program) {
  const folder = mkdtempSync(join(tmpdir(), 'articula-record-'));
  try {
    const [plain, built] = ['plain.glb', 'human.glb'].map((name) => join(folder, name));
    execFileSync(program, ['human', '--quiet', '--triangles', '12000', plain], { stdio: 'inherit' });
    execFileSync(program, ['build', '--quiet', '--levels', '4', plain, built], { stdio: 'inherit' });
    return readFileSync(built);
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** Runs in a page: begins a GIF of frames in `colors` colours and a transparent one, for what is as it was. */
function begin({ colors, delay }) {
  const { GIFEncoder, applyPalette, quantize } = globalThis.gifenc;
  const gif = GIFEncoder();
  let before;
  globalThis.addFrame = async (png) => {
    const picture = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
    const { width, height } = picture;
    const context = new OffscreenCanvas(width, height).getContext('2d');
    context.drawImage(picture, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const palette = quantize(data, colors);
    const indices = applyPalette(data, palette);
    if (before !== undefined) {
      const [now, last] = [new Uint32Array(data.buffer), new Uint32Array(before.buffer)];
      for (let i = 0; i < indices.length; i += 1) {
        if (now[i] === last[i]) {
          indices[i] = palette.length;
        }
      }
    }
    const transparentIndex = palette.length;
    gif.writeFrame(indices, width, height, { palette: [...palette, [0, 0, 0]], delay, transparent: before !== undefined, transparentIndex, dispose: 1 });
    before = data;
  };
  globalThis.endFrames = () => {
    gif.finish();
    let text = '';
    for (const byte of gif.bytes()) {
      text += String.fromCharCode(byte);
    }
    return btoa(text);
  };
}

const program = process.env.ARTICULA ?? fileURLToPath(new URL('../../../target/release/articula', import.meta.url));
const chromium = await browser();
if (chromium === undefined) {
  console.error('record: no Chromium; name one in CHROMIUM');
  process.exit(1);
}
const server = await serve();
try {
  const { page } = await openStudio(chromium, server.address, { hash: '#stage', width: WIDTH, height: HEIGHT });
  await openFile(page, 'human.glb', human(program));
  await page.evaluate(() => globalThis.articulaStudio.viewport.run(false));
  const encoder = await chromium.newPage();
  await encoder.goto(`${server.address}/test/page.html`);
  const source = readFileSync(GIFENC, 'utf8');
  await encoder.evaluate(async (text) => {
    globalThis.gifenc = await import(URL.createObjectURL(new Blob([text], { type: 'text/javascript' })));
  }, source);
  await encoder.evaluate(begin, { colors: COLORS, delay: 1000 / FPS });
  let frames = 0;
  for (const [level, secs] of PARTS) {
    await slide(page, 'Level of articulation', level);
    for (let i = 0; i < Math.round(secs * FPS); i += 1) {
      await page.evaluate((secs) => globalThis.articulaStudio.viewport.step(secs), 1 / FPS);
      const png = await page.screenshot();
      await encoder.evaluate((data) => globalThis.addFrame(data), png.toString('base64'));
      frames += 1;
    }
  }
  const gif = Buffer.from(await encoder.evaluate(() => globalThis.endFrames()), 'base64');
  writeFileSync(OUT, gif);
  console.log(`${OUT}: ${frames} frames, ${(gif.length / 1000).toFixed(0)} kB`);
} finally {
  await chromium.close();
  server.close();
}
