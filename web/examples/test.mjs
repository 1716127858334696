// Opens the example of three-vrm in Chromium and checks what it shows: `npm test`, after `npm ci` here and in the folder above, with the
// modules and the packages built.
import { existsSync } from 'node:fs';
import { mkdir, readFile } from 'node:fs/promises';

import { browser } from '../test/browser.mjs';
import { serve } from '../test/server.mjs';

const OUT = new URL('./out/', import.meta.url);
const DATA = process.env.ARTICULA_DATA ?? new URL('../../../shared/data', import.meta.url).pathname;
const VRM = `${DATA}/vrm/Godette_vrm_v4.vrm`;

const started = await browser();
if (started === undefined) {
  console.log('skipped: examples, no Chromium (set CHROMIUM to its program)');
  process.exit(0);
}
const server = await serve();
await mkdir(OUT, { recursive: true });
const failed = [];
try {
  if (existsSync(VRM)) {
    await test('three-vrm', 'file=/vrm&count=20', async (page) => {
      const near = await picture(page);
      const isNear = await page.evaluate(() => window.example.hero.isNear);
      await page.evaluate(() => window.example.frame(0.1, 15));
      const wasDrawn = await page.evaluate(() => window.example.crowd.levelOf(0) >= 0);
      const far = await picture(page);
      const isRight = isNear && wasDrawn && near.share > 5 && far.share > 1;
      return isRight ? [] : [JSON.stringify({ near, isNear, wasDrawn, far })];
    });
  } else {
    console.log(`skipped: three-vrm, no ${VRM}`);
  }
} finally {
  await started.close();
  server.close();
}
process.exitCode = failed.length === 0 ? 0 : 1;

async function test(name, query, check) {
  const page = await started.newPage({ viewport: { width: 640, height: 360 } });
  const faults = [];
  page.on('pageerror', (error) => faults.push(error.message));
  await page.route((url) => url.pathname === '/vrm', async (route) => route.fulfill({ body: await readFile(VRM) }));
  try {
    await page.goto(`${server.address}/examples/${name}.html?${query}`);
    const isDone = () => window.example !== undefined || document.querySelector('canvas') === null;
    await page.waitForFunction(isDone, undefined, { timeout: 120_000 });
    await page.screenshot({ path: new URL(`${name}.png`, OUT).pathname });
    const said = await page.evaluate(() => (window.example === undefined ? document.body.textContent : ''));
    faults.push(...(said === '' ? await check(page) : [said]));
  } catch (error) {
    faults.push(String(error));
  }
  await page.close();
  if (faults.length > 0) {
    failed.push(name);
  }
  console.log(faults.length === 0 ? `ok      ${name}` : `FAILED  ${name}: ${faults.join('; ')}`);
}

/** The percentage of pixels that are not those of the corner, and by how many levels the brightest and the darkest differ. */
function picture(page) {
  return page.evaluate(() => {
    const from = document.querySelector('canvas');
    const canvas = new OffscreenCanvas(from.width, from.height);
    const context = canvas.getContext('2d');
    context.drawImage(from, 0, 0);
    const { data } = context.getImageData(0, 0, from.width, from.height);
    const greens = [];
    for (let at = 0; at < data.length; at += 4) {
      if (Math.abs(data[at + 1] - data[1]) > 8) {
        greens.push(data[at + 1]);
      }
    }
    const range = greens.reduce(([low, high], g) => [Math.min(low, g), Math.max(high, g)], [255, 0]);
    return { share: (400 * greens.length) / data.length, levels: range[1] - range[0] };
  });
}
