// The page Lighter: a file becomes the one that the program writes, and is shown beside the one that was given.
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

import { axe, openFile, openStudio, slide, step } from './page.mjs';

const KNIGHT = readFileSync(new URL('../../../assets/glb/Quaternius_single_knight_pack__KnightCharacter.glb', import.meta.url));
const OUT = new URL('./out/', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);

/** Greatest distance of a joint of the character after from the same joint before, in metres. */
function farthestJoint(page) {
  return page.evaluate(() => {
    const [before, after] = globalThis.articulaStudio.current.columns.map((column) => column.joints());
    let most = 0;
    for (let joint = 0; joint < before.length; joint += 12) {
      most = Math.max(most, Math.hypot(...[3, 7, 11].map((at) => before[joint + at] - after[joint + at])));
    }
    return before.length === after.length ? most : Infinity;
  });
}

/** Makes the file lighter as the controls say, and returns the one that is downloaded and its name. */
async function lighter(page) {
  await page.evaluate(() => (globalThis.madeBefore = globalThis.articulaStudio.current.made));
  await page.getByRole('button', { name: 'Make it lighter' }).click();
  const isMade = () => {
    const { made } = globalThis.articulaStudio.current;
    return made !== undefined && made !== globalThis.madeBefore;
  };
  await page.waitForFunction(isMade, undefined, { timeout: 60_000 });
  const downloading = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Download' }).click();
  const download = await downloading;
  return { bytes: readFileSync(await download.path()), name: download.suggestedFilename() };
}

export const LIGHTER = [
  {
    name: 'a file becomes the one that the program writes, and moves as before',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#lighter' });
      await openFile(page, 'knight.glb', KNIGHT);
      await slide(page, 'Error in motion', 2);
      const { bytes, name } = await lighter(page);
      const native = programs.optimized(KNIGHT, '--error', '2px');
      let most = 0;
      for (let moment = 0; moment < 12; moment += 1) {
        await step(page, 1, 0.13);
        most = Math.max(most, await farthestJoint(page));
      }
      // A joint may be farther off than any vertex near it, but not by much.
      const bound = (3 * native.report.bound_mm) / 1000;
      const shown = await page.getByText('Error measured', { exact: true }).locator('xpath=following-sibling::dd').textContent();
      await page.getByLabel('Arrays', { exact: true }).selectOption('quantize');
      const plain = await lighter(page);
      const nativePlain = programs.optimized(KNIGHT, '--error', '2px', '--compress', 'quantize');
      const faults = await axe(page);
      await page.screenshot({ path: fileURLToPath(new URL('lighter.png', OUT)) });
      await context.close();
      return [
        ...faults,
        ...errors,
        ...unless(name === 'knight-lighter.glb', `its name is ${name}`),
        ...unless(bytes.equals(native.bytes), `${bytes.length} bytes here, ${native.bytes.length} of the program, or others`),
        ...unless(plain.bytes.equals(nativePlain.bytes), `${plain.bytes.length} bytes here without compression, ${nativePlain.bytes.length} of the program, or others`),
        ...unless(bytes.length < KNIGHT.length / 2, `${bytes.length} of ${KNIGHT.length} bytes`),
        ...unless(most > 0 && most < bound, `joints differ by ${most} m, allowed are ${bound}`),
        ...unless(shown.startsWith(`${native.report.error_mm.toFixed(2)} of`), `it says ${shown}`),
      ];
    },
  },
];
