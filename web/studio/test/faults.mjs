// What goes wrong is told, and the page goes on.
import { openStudio, step } from './page.mjs';

const unless = (right, fault) => (right ? [] : [fault]);

export const FAULTS = [
  {
    name: 'a broken file is told, and the page goes on',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address);
      await page.locator('.top input[type=file]').setInputFiles({ name: 'broken.glb', mimeType: 'model/gltf-binary', buffer: Buffer.from('glTF, or not') });
      await page.getByRole('alert').filter({ hasText: 'broken.glb' }).waitFor();
      const before = await page.evaluate(() => globalThis.articulaStudio.frames);
      await step(page, 2, 1 / 30);
      const { name, frames } = await page.evaluate(() => ({ name: globalThis.articulaStudio.studio.character.name, frames: globalThis.articulaStudio.frames }));
      await page.getByRole('button', { name: 'Close' }).click();
      const faults = [...unless(name === 'human.glb' && frames > before, `shows ${name} after ${frames} frames`)];
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'a lost context is told and comes back, and links with nonsense are read as far as they go',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?count=nine&radius=99&body=paper&clip=%00&columns=two&depth=-4' });
      const state = await page.evaluate(() => globalThis.articulaStudio.studio.state);
      const faults = unless(state.count === 1000 && state.radius === 3 && state.body === 'clear' && state.columns === 'two' && state.depth === 0, JSON.stringify(state));
      const note = page.getByRole('alert').filter({ hasText: 'graphics context' });
      await page.evaluate(() => {
        globalThis.lost = globalThis.articulaStudio.viewport.renderer.getContext().getExtension('WEBGL_lose_context');
        globalThis.lost.loseContext();
      });
      await note.waitFor();
      await page.evaluate(() => globalThis.lost.restoreContext());
      await note.waitFor({ state: 'hidden' });
      await page.evaluate(() => globalThis.articulaStudio.viewport.step(1 / 30));
      await context.close();
      // three.js tells of the loss itself.
      return [...faults, ...errors.filter((error) => !error.includes('Context Lost'))];
    },
  },
  {
    name: 'a browser without WebGL is told so',
    async run({ browser, server }) {
      const context = await browser.newContext();
      const page = await context.newPage();
      const errors = [];
      page.on('pageerror', (error) => errors.push(error.message));
      page.on('console', (message) => errors.push(...(message.type() === 'error' ? [message.text()] : [])));
      await page.addInitScript(() => {
        HTMLCanvasElement.prototype.getContext = () => null;
      });
      await page.goto(`${server.address}/studio/dist/index.html`);
      await page.getByRole('alert').filter({ hasText: 'no WebGL 2' }).waitFor({ timeout: 10_000 });
      await context.close();
      return errors;
    },
  },
];
