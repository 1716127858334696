// The page Flat: what was moved by hand becomes a picture; one behind it is shown, and goes into the SVG that is taken home.
import { readFile } from 'node:fs/promises';

import { axe, openFile, openStudio, slide, step } from './page.mjs';

const unless = (right, fault) => (right ? [] : [fault]);

/** A PNG of one red pixel, made by the browser. */
const red = (page) => page.evaluate(() => {
  const canvas = Object.assign(document.createElement('canvas'), { width: 1, height: 1 });
  const context = canvas.getContext('2d');
  context.fillStyle = '#f00';
  context.fillRect(0, 0, 1, 1);
  return canvas.toDataURL('image/png').split(',')[1];
});

/** Elements of an SVG, and the colour of its corner where it is shown as a picture. */
const shown = (page, svg) => page.evaluate(async (text) => {
  const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
  const image = new Image();
  image.src = URL.createObjectURL(new Blob([text], { type: 'image/svg+xml' }));
  await image.decode();
  const canvas = Object.assign(document.createElement('canvas'), { width: image.naturalWidth, height: image.naturalHeight });
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  return {
    fault: parsed.querySelector('parsererror')?.textContent,
    images: parsed.querySelectorAll('image').length,
    first: parsed.documentElement.firstElementChild.localName,
    corner: [...context.getImageData(1, 1, 1, 1).data],
  };
}, svg);

export const FLAT = [
  {
    name: 'expressions that are moved by hand become a clip, then a picture with a background',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { width: 1280, height: 800 });
      await openFile(page, 'face.csv', 'Timecode,jawOpen\n00:00:00.0,0\n00:00:00.1,0\n');
      await page.locator('summary', { hasText: /^Face$/ }).click();
      await page.getByRole('button', { name: 'Record', exact: true }).last().click();
      // The jaw opens by a tenth in each of ten frames.
      for (let frame = 0; frame <= 10; frame += 1) {
        await slide(page, 'jawOpen', frame / 10);
        await step(page, 1, 1 / 30);
      }
      await page.getByRole('button', { name: 'Stop recording' }).click();
      await page.getByText('recorded-1.csv now moves human.glb').waitFor({ timeout: 30_000 });
      const weights = await page.evaluate(() => {
        const { current, studio } = globalThis.articulaStudio;
        // Its tables are not needed for a picture.
        studio.task.cancel();
        const at = (secs) => {
          current.seek(secs);
          return Math.max(...current.columns[0].figure.mesh.morphTargetInfluences);
        };
        return { clip: studio.state.clip, half: at(5 / 30), whole: at(0.3332) };
      });
      await page.getByRole('link', { name: 'Flat' }).click();
      await page.evaluate(() => globalThis.articulaStudio.studio.set({ triangles: 100 }));
      await page.getByRole('button', { name: 'Make the picture' }).click();
      await page.locator('.flat-picture img').waitFor({ timeout: 60_000 });
      const told = await page.locator('.readout').textContent();

      const choose = (name, mimeType, buffer) => page.getByLabel('Background picture', { exact: true }).setInputFiles({ name, mimeType, buffer });
      await choose('notes.txt', 'text/plain', Buffer.from('no picture'));
      await page.getByRole('alert').filter({ hasText: 'notes.txt: a background is a PNG, JPEG or WebP picture' }).waitFor();
      await page.getByRole('button', { name: 'Close' }).click();
      await choose('red.png', 'image/png', Buffer.from(await red(page), 'base64'));
      await page.getByText('red.png is behind it').waitFor();
      const save = async () => {
        const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download' }).click()]);
        return shown(page, await readFile(await saved.path(), 'utf8'));
      };
      const filled = await save();
      const width = await page.locator('.backdrop').evaluate((image) => image.naturalWidth * image.clientWidth);
      const faults = await axe(page);
      await page.screenshot({ path: new URL('./out/flat-background.png', import.meta.url).pathname });
      await page.getByRole('button', { name: 'Remove it' }).click();
      const bare = await save();
      await context.close();
      return [
        ...faults,
        ...errors,
        ...unless(weights.clip === 'recorded-1' && Math.abs(weights.half - 0.5) < 0.02 && Math.abs(weights.whole - 1) < 0.02, JSON.stringify(weights)),
        ...unless(/Frames(8|9|10) at/.test(told), told),
        ...unless(filled.fault === undefined && filled.first === 'image' && filled.images === 1 && filled.corner.join() === '255,0,0,255', JSON.stringify(filled)),
        ...unless(width > 0, 'the page does not show it'),
        ...unless(bare.images === 0 && bare.corner[3] === 0, JSON.stringify(bare)),
      ];
    },
  },
];
