// The page Flat: what was moved by hand becomes a picture; one behind it is shown, and goes into the SVG that is taken home.
import { readFile } from 'node:fs/promises';

import { axe, draw, openFile, openStudio, slide, step } from './page.mjs';

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

/** Whether a canvas shows something, and where: the share of its width at which the middle of what it shows is. */
const painted = (page, selector) => page.locator(selector).evaluate((canvas) => {
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  let [count, sum] = [0, 0];
  for (let i = 0; i < width * height; i += 1) {
    if (data[4 * i + 3] > 0) {
      count += 1;
      sum += i % width;
    }
  }
  return { share: count / (width * height), middle: sum / Math.max(count, 1) / width };
});

export const FLAT = [
  {
    name: 'a head becomes a portrait that plays, turns, and goes home as a page with a background',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#flat?form=portrait', width: 1280, height: 800 });
      // A head without expressions is a portrait soon.
      const bytes = await readFile(new URL('../dist/mannequin.glb', import.meta.url));
      await openFile(page, 'mannequin.glb', bytes);
      await page.evaluate(() => {
        const { studio } = globalThis.articulaStudio;
        studio.task.cancel();
        studio.set({ triangles: 200, clip: 'wave' });
      });
      await page.getByRole('button', { name: 'Make the picture' }).click();
      await page.locator('.flat-picture canvas').waitFor({ timeout: 90_000 });
      const plays = await page.waitForFunction(() => globalThis.articulaStudio.current.portrait?.face.frames > 1).then(() => true, () => false);
      const told = await page.locator('.readout').textContent();
      await slide(page, 'Head of the portrait', 40);
      const turned = await painted(page, '.flat-picture canvas');
      await slide(page, 'Head of the portrait', -40);
      const other = await painted(page, '.flat-picture canvas');
      await draw(page);
      const faults = await axe(page);
      await page.screenshot({ path: new URL('./out/flat-portrait.png', import.meta.url).pathname });
      await page.getByLabel('Background picture', { exact: true }).setInputFiles({ name: 'red.png', mimeType: 'image/png', buffer: Buffer.from(await red(page), 'base64') });
      await page.getByText('red.png is behind it').waitFor();
      const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download' }).click()]);
      const html = await readFile(await saved.path(), 'utf8');
      // The page stands alone: it is opened with nothing around it.
      const alone = await context.newPage();
      alone.on('pageerror', (error) => errors.push(`portrait: ${error.message}`));
      await alone.setContent(html);
      await alone.evaluate(() => globalThis.articulaReady);
      await alone.evaluate(() => globalThis.articulaSeek(0.5));
      const corner = await alone.locator('#portrait').evaluate((canvas) => [...canvas.getContext('2d').getImageData(2, 2, 1, 1).data]);
      // A level told right after a motion does not take its place, and what is no message for a face does nothing.
      const driven = await alone.evaluate(async () => {
        const face = globalThis.articulaPortrait;
        const told = [{ articula: 'face', head: { yaw: 12 } }, { articula: 'face', level: 'low' }, { articula: 'other', level: 'high', head: { yaw: -9 } }];
        const last = new Promise((done) => globalThis.addEventListener('message', ({ data }) => data === 'last' && done()));
        for (const message of [...told, 'last']) globalThis.postMessage(message, '*');
        await last;
        await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
        return `${face.driven?.pose.yaw} ${face.level}`;
      });
      const native = programs.flattened(bytes, 'portrait.html', '--triangles', '200', '--clip', 'wave');
      const errorsOf = native.error.map(({ yaw_deg: yaw, image_rmse_levels: levels }) => `${yaw === 0 ? 'Error from the front' : `Error at ${yaw}°`}${levels.toFixed(1)} of 255`);
      await context.close();
      return [
        ...faults,
        ...errors,
        ...unless(plays && turned.share > 0.1 && Math.abs(turned.middle - other.middle) > 0.005, `plays: ${plays}, ${JSON.stringify([turned, other])}`),
        ...unless(/Pictures of the head3/.test(told) && errorsOf.length === 5 && told.includes(errorsOf.join('')), `${told} in place of ${errorsOf}`),
        ...unless(saved.suggestedFilename() === 'mannequin.portrait.html' && corner.join() === '255,0,0,255', `${saved.suggestedFilename()}: corner ${corner}`),
        ...unless(driven === '12 low', `messages drive the page: ${driven}`),
      ];
    },
  },
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
