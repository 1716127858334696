// The page Flat: a picture behind the character is shown, and goes into the SVG that is taken home.
import { readFile } from 'node:fs/promises';

import { axe, openFile, openStudio } from './page.mjs';

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
    name: 'a background picture is behind the character, on the page and in the SVG',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#flat?triangles=100', width: 1280, height: 800 });
      await openFile(page, 'knight.glb', programs.bytes);
      const choose = (name, mimeType, buffer) => page.getByLabel('Background picture', { exact: true }).last().setInputFiles({ name, mimeType, buffer });
      await choose('notes.txt', 'text/plain', Buffer.from('no picture'));
      await page.getByRole('alert').filter({ hasText: 'notes.txt: a background is a PNG, JPEG or WebP picture' }).waitFor();
      await page.getByRole('button', { name: 'Close' }).click();
      await choose('red.png', 'image/png', Buffer.from(await red(page), 'base64'));
      await page.getByText('red.png is behind it').waitFor();
      await page.getByRole('button', { name: 'Make the picture' }).click();
      await page.locator('.flat-picture img').waitFor({ timeout: 60_000 });
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
        ...unless(filled.fault === undefined && filled.first === 'image' && filled.images === 1 && filled.corner.join() === '255,0,0,255', JSON.stringify(filled)),
        ...unless(width > 0, 'the page does not show it'),
        ...unless(bare.images === 0 && bare.corner[3] === 0, JSON.stringify(bare)),
      ];
    },
  },
];
