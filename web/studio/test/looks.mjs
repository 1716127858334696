// Pages at the sizes of a desk and of a telephone, light and dark: no fault that axe finds, nothing wider than the page.
import { axe, draw, openStudio } from './page.mjs';

const OUT = new URL('./out/', import.meta.url);
const SIZES = [
  ['desk', 1280, 800],
  ['phone', 360, 740],
];

const looks = (hash, name) => ({
  name: `${name} is readable at all sizes and in both themes`,
  async run({ browser, server }) {
    const faults = [];
    const { context, page, errors } = await openStudio(browser, server.address, { hash });
    for (const [kind, width, height] of SIZES) {
      await page.setViewportSize({ width, height });
      for (const colorScheme of ['light', 'dark']) {
        await page.emulateMedia({ colorScheme, reducedMotion: 'reduce' });
        await draw(page);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
        faults.push(...(await axe(page)).map((fault) => `${kind} ${colorScheme} ${fault}`));
        if (wide > 0) {
          faults.push(`${kind}: ${wide} px wider than the page`);
        }
        await page.screenshot({ path: new URL(`${name}-${kind}-${colorScheme}.png`, OUT).pathname });
      }
    }
    await context.close();
    return [...faults, ...errors];
  },
});

export const LOOKS = [looks('#stage', 'stage'), looks('#crowd?count=25', 'crowd'), looks('#flat', 'flat'), looks('#lighter', 'lighter'), looks('#stream', 'stream'), looks('#devices', 'devices')];
