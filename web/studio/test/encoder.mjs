// The encoder of the page Stream: streams and the documents by which they are cut, as the program writes them.
import { readFile } from 'node:fs/promises';

import { axe, openFile, openStudio, slide } from './page.mjs';

const FAP = new URL('../../../assets/fap/speech_synthetic.fap', import.meta.url);
const OUT = new URL('./out/', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);

/** Vectors of numbers of an AQoS, by the pins to which they belong. */
const table = (page, xml) => page.evaluate((text) => {
  const parsed = new DOMParser().parseFromString(text, 'application/xml');
  const pins = [...parsed.querySelectorAll('Axis, Content')].map((element) => [element.getAttribute('iOPinRef'), element.textContent.trim().split(/\s+/).map(Number)]);
  return { fault: parsed.querySelector('parsererror')?.textContent, pins: Object.fromEntries(pins) };
}, xml);

export const ENCODER = [
  {
    name: 'a clip and a face are encoded, with the documents that describe them',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stream', width: 1280, height: 900 });
      await openFile(page, 'knight.glb', programs.bytes);
      await page.locator('summary', { hasText: /^Encoder$/ }).click();
      const files = async (press) => {
        await page.getByLabel('Files of the encoder').evaluate((group) => group.replaceChildren());
        await press();
        await page.getByLabel('Files of the encoder').getByRole('button').first().waitFor({ timeout: 60_000 });
        const made = {};
        for (const save of await page.getByLabel('Files of the encoder').getByRole('button').all()) {
          const [file] = await Promise.all([page.waitForEvent('download'), save.click()]);
          made[file.suggestedFilename()] = await readFile(await file.path());
        }
        return made;
      };
      const encode = () => files(() => page.getByRole('button', { name: 'Encode the clip' }).click());
      const named = (made, ending) => Object.entries(made).find(([name]) => name.endsWith(ending)) ?? ['', Buffer.alloc(0)];

      // Within an error: the description is the one that the program makes of the stream.
      const layered = await encode();
      const [abp, bytes] = named(layered, '.abp');
      const [, gbsd] = named(layered, '.gbsd.xml');
      const { fault, pins } = await table(page, named(layered, 'aqos.xml')[1].toString());
      const { BANDWIDTH: rates, ...wanted } = pins;
      await page.screenshot({ path: new URL('stream-encoder.png', OUT).pathname });
      const faults = [
        ...(await axe(page)),
        ...unless(Object.keys(layered).length === 3 && gbsd.toString().trimEnd() === programs.described(bytes, abp), `${Object.keys(layered)}: a description of ${gbsd.length} bytes`),
        ...unless(fault === undefined && rates.length > 4 && rates.every((rate, i) => i === 0 || rate === 2 * rates[i - 1]) && Object.values(wanted).length > 2 && Object.values(wanted).every((values) => values.length === rates.length), JSON.stringify({ fault, pins })),
      ];
      await slide(page, 'Error of the finest layer', 1);
      const coarse = named(await encode(), '.abp')[1];
      faults.push(...unless(coarse.length < bytes.length, `${coarse.length} bytes within 10 mm, ${bytes.length} within 0.1`));

      // Quantised: the finest steps are those of the program.
      await page.locator('.segmented label', { hasText: /^Quantised$/ }).click();
      const fine = await encode();
      const [name, quantised] = named(fine, '.abp');
      const native = programs.converted(programs.bytes, 'abp', '--stream', 'profile=abp1');
      faults.push(...unless(quantised.equals(native), `${quantised.length} bytes, ${native.length} of the program, or others`));
      faults.push(...unless(Object.keys(fine).length === 2 && named(fine, '.gbsd.xml')[1].toString().trimEnd() === programs.described(quantised, name), `${Object.keys(fine)}`));
      await slide(page, 'Quantiser', 31);
      await slide(page, 'Frames left out between two', 3);
      const rough = named(await encode(), '.abp')[1];
      faults.push(...unless(rough.length < quantised.length, `${rough.length} bytes in large steps, ${quantised.length} in small ones`));

      // Facial animation parameters, without a character.
      const face = async () => files(() => page.getByLabel('Facial animation parameters', { exact: true }).setInputFiles({ name: 'speech.fap', mimeType: 'application/octet-stream', buffer: fap }));
      const fap = await readFile(FAP);
      await slide(page, 'Quantiser', 1);
      const spoken = await face();
      const afp = programs.encodedFace(fap, 'profile=afp1');
      faults.push(...unless(spoken['speech.afp']?.equals(afp) && spoken['speech.gbsd.xml']?.toString().trimEnd() === programs.described(afp, 'speech.afp'), `${Object.keys(spoken)}: ${spoken['speech.afp']?.length} bytes, ${afp.length} of the program`));
      await page.getByLabel('Facial animation parameters', { exact: true }).setInputFiles({ name: 'none.fap', mimeType: 'application/octet-stream', buffer: Buffer.from('no parameters') });
      await page.getByRole('alert').filter({ hasText: 'none.fap' }).waitFor();
      await context.close();
      return [...faults, ...errors];
    },
  },
];
