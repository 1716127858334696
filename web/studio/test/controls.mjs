// The knobs of the metric, of transitions and of place, each by what it changes in what is shown.
import { readFile } from 'node:fs/promises';

import { openStudio, slide, step } from './page.mjs';

const SECS = 1 / 30;
const HUMAN = new URL('../dist/human.glb', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);

const press = (page, text) => page.locator('.segmented label', { hasText: text }).click();
const updated = (page) => page.evaluate(() => globalThis.articulaStudio.current.columns[0].figures().updated);
const pose = (page) => page.evaluate(() => globalThis.articulaStudio.current.columns[0].joints().slice().join());
const stand = (page, metres) => page.evaluate((z) => globalThis.articulaStudio.viewport.place(`0,1,${z},0,1,0`), metres);

export const CONTROLS = [
  {
    name: 'the knobs of thresholds, transitions, place and speed do what they say',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?transition=0', width: 1280, height: 700 });
      const faults = [];
      // At the viewer no error is let pass, at 16 m any: the distance alone decides, when it is looked up.
      await press(page, /^Threshold$/);
      await slide(page, 'Threshold at the viewer', -6);
      await slide(page, 'Threshold at 16 m', 0);
      await press(page, /^Rising$/);
      await stand(page, 2);
      await slide(page, 'Look-up', 20);
      await step(page, 22, SECS);
      const near = await updated(page);
      await stand(page, 16);
      await step(page, 5, SECS);
      const unseen = await updated(page);
      await step(page, 20, SECS);
      const far = await updated(page);
      faults.push(...unless(unseen === near && far < near / 2, `${near} joints near, ${unseen} before the look-up, ${far} after it`));
      await slide(page, 'Look-up', 1);
      const at = async (curve) => {
        await press(page, curve);
        await stand(page, 6);
        await step(page, 2, SECS);
        return updated(page);
      };
      const curves = [await at(/^Rising$/), await at(/^As printed$/)];
      faults.push(...unless(curves[0] !== curves[1], `both curves move ${curves[0]} joints at 6 m`));
      // Another weight holds other joints than the errors of the file do, which come back; one threshold at all distances.
      await press(page, /^Rising$/);
      await slide(page, 'Threshold at the viewer', -1);
      await slide(page, 'Threshold at 16 m', -1);
      const weighed = async (beta) => {
        await slide(page, 'Orientation against velocity (β)', beta);
        await page.waitForFunction((b) => globalThis.articulaStudio.current.weight === b, beta, { timeout: 60_000 });
        await page.evaluate(() => globalThis.articulaStudio.current.seek(0));
        const counts = [];
        for (let frame = 0; frame < 12; frame += 1) {
          await page.evaluate((secs) => globalThis.articulaStudio.current.seek(secs), frame * SECS);
          counts.push(await updated(page));
        }
        return counts.join();
      };
      const weights = [await weighed(0), await weighed(1), await weighed(0.5), await weighed(0)];
      faults.push(...unless(weights[0] === weights[3] && new Set(weights).size === 3, `joints by weight: ${weights.join('; ')}`));
      // Columns that come while errors are found get them too, and those that come afterwards have them at once.
      await slide(page, 'Orientation against velocity (β)', 1);
      await press(page, /^All levels$/);
      await page.waitForFunction(() => globalThis.articulaStudio.current.weight === 1, undefined, { timeout: 60_000 });
      await press(page, /^One view$/);
      const again = await weighed(1);
      const told = await page.getByRole('alert').filter({ visible: true }).count();
      faults.push(...unless(again === weights[1] && told === 0, `after other columns: ${again}, before ${weights[1]}, ${told} faults told`));
      await slide(page, 'Orientation against velocity (β)', 0.5);
      await press(page, /^None$/);

      // What passive joints show, and how they get there.
      const rested = async (kind) => {
        await press(page, kind);
        await slide(page, 'Level of articulation', 0);
        await page.evaluate(() => globalThis.articulaStudio.current.seek(0.3));
        await step(page, 2, SECS);
        await slide(page, 'Level of articulation', 1);
        await step(page, 2, SECS);
        return pose(page);
      };
      faults.push(...unless((await rested(/^Last pose$/)) !== (await rested(/^Rest pose$/)), 'passive joints show the same at both'));
      const amid = async (course) => {
        await press(page, course);
        await slide(page, 'Level of articulation', 0);
        await slide(page, 'Transition', 1);
        await step(page, 2, SECS);
        await slide(page, 'Level of articulation', 1);
        await step(page, 6, SECS);
        return pose(page);
      };
      faults.push(...unless((await amid(/^Smooth$/)) !== (await amid(/^Linear$/)), 'both courses show the same amid a transition'));

      await page.locator('summary', { hasText: 'Placement' }).click();
      await slide(page, 'To the front', -3);
      await page.getByLabel('Speed', { exact: true }).selectOption('0.5');
      const clock = await page.evaluate((secs) => {
        const { current, viewport } = globalThis.articulaStudio;
        current.timeline.restart(0);
        viewport.advance(secs);
        return { secs: current.timeline.secs, z: current.columns[0].root.position.z };
      }, 0.2);
      faults.push(...unless(Math.abs(clock.secs - 0.1) < 1e-6 && clock.z === -3, JSON.stringify(clock)));

      await page.locator('summary', { hasText: 'Take home' }).click();
      const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Prepared GLB' }).click()]);
      const glb = await readFile(await saved.path());
      faults.push(...unless(glb.subarray(0, 4).toString() === 'glTF' && saved.suggestedFilename() === 'human-prepared.glb', saved.suggestedFilename()));
      const take = async (name) => {
        const [file] = await Promise.all([page.waitForEvent('download', { timeout: 30_000 }), page.getByRole('button', { name }).click()]);
        return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
      };
      const png = await take('Picture (PNG)');
      // A character and its skeleton take more bytes than one colour does.
      faults.push(...unless(png.name === 'human.png' && png.bytes.subarray(1, 4).toString() === 'PNG' && png.bytes.length > 10_000, `${png.name}: ${png.bytes.length} bytes`));
      const abp = await take('Motion (ABP)');
      const native = programs.converted(await readFile(HUMAN), 'abp', '--clip', 'walk');
      faults.push(...unless(abp.name === 'human-walk.abp' && abp.bytes.equals(native), `${abp.name}: ${abp.bytes.length} bytes, ${native.length} of the program, or others`));
      // The motion of the joints that a level leaves active, as the program writes it.
      await page.getByLabel('Motions of the active joints alone', { exact: true }).check();
      await page.getByLabel('Expression, in place of the selectors').fill('loa(Low)');
      for (const [label, to] of [['Motion (ABP)', 'abp'], ['Motion (GLB)', 'glb']]) {
        const own = await take(label);
        const held = programs.converted(await readFile(HUMAN), to, '--clip', 'walk', '--loa', 'loa(Low)', '--passive', 'rest');
        const whole = programs.converted(await readFile(HUMAN), to, '--clip', 'walk');
        faults.push(...unless(own.name === `human-walk-active.${to}` && own.bytes.equals(held) && held.length < whole.length, `${own.name}: ${own.bytes.length} bytes, ${held.length} of the program, ${whole.length} of all joints`));
      }
      await page.locator('.said', { hasText: /^\d+ of 89 joints move: .* in place of / }).waitFor();
      await context.close();
      return [...faults, ...errors];
    },
  },
];
