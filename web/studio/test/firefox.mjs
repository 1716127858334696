// Each page once in Firefox, where playwright has one.
import { firefox } from '../../test/browser.mjs';
import { openStudio, step } from './page.mjs';

const PAGES = ['stage', 'crowd?count=25', 'flat', 'lighter', 'stream', 'devices'];

const started = await firefox();
if (started === undefined) {
  console.log("skipped: pages of the studio in Firefox (none of playwright's; set FIREFOX to its program)");
}

const inFirefox = (hash) => ({
  name: `the page ${hash} is shown in Firefox`,
  async run({ server }) {
    const { context, page, errors } = await openStudio(started, server.address, { hash: `#${hash}` });
    await step(page, 2, 1 / 30);
    const { frames, title } = await page.evaluate(() => ({ frames: globalThis.articulaStudio.frames, title: document.title }));
    await context.close();
    return [...errors, ...(frames > 3 && title.endsWith('Articula studio') ? [] : [`${frames} frames of ${title}`])];
  },
});

export const FIREFOX = started === undefined ? [] : PAGES.map(inFirefox);
export const closeFirefox = () => started?.close();
