// With the network cut after loading: a file of the library is dropped, and shows and measures what it does natively.
import { readFile, writeFile } from 'node:fs/promises';

import { column, openFile, openStudio, step } from './page.mjs';

const FRAMES = 12;
const EXPRESSION = 'loa(Low) + zone(hands)';
const unless = (right, fault) => (right ? [] : [fault]);
const OUT = new URL('./out/', import.meta.url);

/** Hash FNV-1a of the palettes at the times of twelve frames of a sixtieth of a second, as FigurePlayer adds them up. */
const palettes = (page) => page.evaluate((frames) => {
  const { current } = globalThis.articulaStudio;
  let hash = 0xcbf29ce484222325n;
  let secs = 0;
  for (let frame = 0; frame < frames; frame += 1) {
    secs = Math.fround(secs + Math.fround(1 / 60));
    current.seek(secs);
    const palette = current.columns[0].palette();
    for (const byte of new Uint8Array(palette.buffer, palette.byteOffset, palette.byteLength)) {
      hash = BigInt.asUintN(64, (hash ^ BigInt(byte)) * 0x100000001b3n);
    }
  }
  return hash.toString(16).padStart(16, '0');
}, FRAMES);

/** Rounds as far as three digits say. */
const digits = (value) => (typeof value === 'number' ? Number(value.toPrecision(3)) : value);

export const OFFLINE = [
  {
    name: 'without a network a dropped file shows, measures and flattens as the library does',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?transition=0&body=solid' });
      await page.evaluate(() => globalThis.articulaStudio.studio.tools.keep());
      await context.setOffline(true);
      const faults = [...unless((await openFile(page, 'knight.glb', programs.bytes)) === 'knight.glb', 'the file is not shown')];
      const shown = await palettes(page);
      faults.push(...unless(shown === programs.palettes, `palettes ${shown}, natively ${programs.palettes}`));

      await page.getByLabel('Expression, in place of the selectors').fill(EXPRESSION);
      await step(page, 2, 1 / 60);
      const { states } = await column(page);
      const active = await page.evaluate((all) => globalThis.articulaStudio.studio.character.asset.joints.filter((_, i) => all[i] === 1), states);
      const natively = programs.joints(EXPRESSION);
      faults.push(...unless(active.toSorted().join() === natively.toSorted().join(), `${active} move, natively ${natively}`));

      await page.locator('#evaluate summary').first().click();
      await page.getByRole('button', { name: 'Evaluate' }).click();
      await page.locator('#evaluate tbody tr').first().waitFor();
      const told = JSON.parse(await page.locator('#evaluate .results').getAttribute('data-rows'));
      const rows = programs.rows('--calibrate', '1');
      const flat = (row) => JSON.stringify(row, (_, value) => digits(value));
      faults.push(...unless(told.length === 5 && told.length === rows.length, `${told.length} rows, natively ${rows.length}`));
      rows.forEach((row, i) => faults.push(...unless(flat(told[i]) === flat(row), `row ${i}: ${flat(told[i])}, natively ${flat(row)}`)));

      await page.getByRole('link', { name: 'Flat' }).click();
      await page.evaluate(() => globalThis.articulaStudio.studio.set({ triangles: 100 }));
      await page.getByRole('button', { name: 'Make the picture' }).click();
      await page.locator('.flat-picture img').waitFor({ timeout: 60_000 });
      const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download' }).click()]);
      const svg = await readFile(await saved.path(), 'utf8');
      await writeFile(new URL('knight.svg', OUT), svg);
      const { fault, root, animated, width } = await page.evaluate(async (text) => {
        const parsed = new DOMParser().parseFromString(text, 'image/svg+xml');
        const image = document.querySelector('.flat-picture img');
        await image.decode();
        return { fault: parsed.querySelector('parsererror')?.textContent, root: parsed.documentElement.localName, animated: parsed.querySelectorAll('animate, animateTransform, set').length, width: image.naturalWidth };
      }, svg);
      faults.push(...unless(fault === undefined && root === 'svg' && animated > 10 && width > 0 && !svg.includes('<script'), `SVG: ${fault ?? root}, ${animated} animations, ${width} px wide`));
      faults.push(...unless(saved.suggestedFilename() === 'knight.svg', saved.suggestedFilename()));

      const make = async (form, picture) => {
        await page.locator('.segmented label', { hasText: form }).click();
        await page.getByRole('button', { name: 'Make the picture' }).click();
        await page.locator(picture).first().waitFor({ timeout: 60_000 });
        return page.locator('.readout').textContent();
      };
      const player = await make('Player', '.flat-picture canvas');
      await page.waitForFunction(() => {
        const canvas = document.querySelector('.flat-picture canvas');
        const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
        return pixels.some((value, i) => i % 4 === 3 && value > 0);
      });
      const lottie = await make('Lottie', '.lottie svg path');
      faults.push(...unless(/gzip[\d.]+ k?B/.test(player) && player !== lottie, `player: ${player}; Lottie: ${lottie}`));
      await context.close();
      return [...faults, ...errors];
    },
  },
];
