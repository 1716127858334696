// Each page once in Firefox, where it is installed.
import { firefox } from '../../test/firefox.mjs';

const PAGES = ['stage', 'crowd?count=25', 'flat', 'lighter', 'stream', 'devices'];
const OUT = new URL('./out/', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);

/** Started by the first of the tests. */
let started;

const inFirefox = (hash) => ({
  name: `the page ${hash} is shown in Firefox`,
  async run({ server }) {
    started ??= await firefox();
    if (started.missing !== undefined) {
      return { skipped: `pages of the studio in Firefox (${started.missing})` };
    }
    const context = await started.browser.createBrowserContext();
    const page = await context.newPage();
    const errors = [];
    page.on('pageerror', (error) => errors.push(`page: ${error.message}`));
    page.on('console', (message) => errors.push(...unless(message.type() !== 'error', `console: ${message.text()}`)));
    await page.setViewport({ width: 1280, height: 800 });
    await page.goto(`${server.address}/studio/dist/index.html#${hash}`);
    await page.waitForFunction(() => globalThis.articulaStudio?.frames > 3, { timeout: 60_000 });
    const { frames, title, pixels } = await page.evaluate(() => {
      const { viewport } = globalThis.articulaStudio;
      viewport.run(false);
      viewport.step(1 / 30);
      const gl = viewport.renderer.getContext();
      const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
      const all = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, all);
      return { frames: viewport.frames, title: document.title, pixels: all.reduce((sum, byte, i) => sum + (i % 4 === 3 && byte > 0 ? 1 : 0), 0) };
    });
    const name = hash.replace(/\?.*/, '');
    await page.screenshot({ path: new URL(`firefox-${name}.png`, OUT).pathname });
    await context.close();
    return [...errors, ...unless(frames > 3 && title.endsWith('Articula studio'), `${frames} frames of ${title}`), ...unless(pixels > 1000 || name === 'stream', `${pixels} pixels are drawn`)];
  },
});

export const FIREFOX = PAGES.map(inFirefox);
export const closeFirefox = () => started?.end?.();
