// The page Stream beside a server of characters: what comes follows the bandwidth, and the server knows its sessions.
import { fileURLToPath } from 'node:url';

import { openStore, PROGRAM } from '../../test/store.mjs';
import { axe, openStudio, slide } from './page.mjs';

const KNIGHT = 'glb/Quaternius_single_knight_pack__KnightCharacter.glb';
const CLIP = 'HumanArmature|Walking';
const DIST = fileURLToPath(new URL('../dist', import.meta.url));
const OUT = new URL('./out/', import.meta.url);
const PATH = '/studio/index.html';
/** The last stop of the slider: as much as comes. */
const ALL = 11;
const unless = (right, fault) => (right ? [] : [fault]);

/** What all tests share: the server packages once. */
let store;
const address = async () => {
  store ??= await openStore(KNIGHT, CLIP, 'knight', ['--studio', DIST]);
  return store.url.replace(/\/$/, '');
};

export async function closeStore() {
  await store?.close();
}

/** Opens the page at its server, whose frames go on by themselves. */
async function open(browser, hash) {
  const opened = await openStudio(browser, await address(), { hash, path: PATH });
  await opened.page.evaluate(() => globalThis.articulaStudio.viewport.run(true));
  return opened;
}

/** Waits until the stream is in a state, and returns its report. */
async function reached(page, state) {
  await page.waitForFunction((wanted) => globalThis.articulaStudio.current.stream?.state === wanted, state, { timeout: 40_000 });
  return page.evaluate(() => globalThis.articulaStudio.current.stream.report);
}

const both = ['session', 'http'].map((by) => ({
  name: `a character of the server arrives at a bandwidth, and whole without one (${by})`,
  async run({ browser }) {
    const { context, page, errors } = await open(browser, `#stream?by=${by}&kbps=64`);
    const base = await reached(page, 'base');
    const slow = await page.evaluate(() => {
      const { mesh, clips } = globalThis.articulaStudio.current.stream;
      return { triangles: mesh.geometry.index.count / 3, clips: [...clips] };
    });
    await slide(page, 'Bandwidth', ALL);
    const whole = await reached(page, 'complete');
    const triangles = await page.evaluate(() => globalThis.articulaStudio.current.stream.mesh.geometry.index.count / 3);
    const shown = await page.getByText('Received', { exact: true }).locator('xpath=following-sibling::dd').textContent();
    const reason = await page.locator('.panel .said').first().textContent();
    const events = await page.getByLabel('Events', { exact: true }).textContent();
    await page.screenshot({ path: fileURLToPath(new URL(`stream-${by}.png`, OUT)) });
    const faults = by === 'session' ? await axe(page) : [];
    await context.close();
    return [
      ...faults,
      ...errors,
      ...unless(slow.clips.join() === CLIP, `clips: ${slow.clips}`),
      ...unless(whole.bytes > base.bytes, `${base.bytes} bytes at first, then ${whole.bytes}`),
      ...unless(triangles >= slow.triangles && whole.level === whole.levels, `${slow.triangles} triangles, then ${triangles}; level ${whole.level} of ${whole.levels}`),
      ...unless(/kB$/.test(shown), `received: ${shown}`),
      ...unless(/^All that 0.5 px at this distance asks for is here/.test(reason), `its reason: ${reason}`),
      ...unless(/context: any rate, 0.5 px, any memory/.test(events) && /level \d of \d: \S/.test(events), `no decisions among ${events}`),
      ...unless(/all that is asked for is here/.test(events) && /the base is here/.test(events), `events: ${events}`),
    ];
  },
}));

const TESTS = [
  ...both,
  {
    name: 'sessions of a page and of others are listed, each at its own rate, and end with their pages',
    async run({ browser }) {
      const url = await address();
      const count = async () => (await (await fetch(`${url}/v1/sessions`)).json()).length;
      // The first page has two.
      const first = await open(browser, '#stream?beside=16');
      const second = await open(browser, '#stream');
      const whole = await reached(first.page, 'complete');
      await reached(second.page, 'complete');
      await first.page.waitForFunction(() => [...document.querySelectorAll('dt')].some((dt) => dt.textContent === 'The other session' && /^level [1-9]/.test(dt.nextElementSibling.textContent)));
      const scenes = await first.page.evaluate(() => globalThis.articulaStudio.viewport.scene.children.filter((child) => child.report !== undefined).map((child) => ({ x: child.position.x, bytes: child.report.bytes })));
      await first.page.getByText('Sessions of the server').click();
      const rows = first.page.getByRole('region', { name: 'Sessions' }).locator('tbody tr');
      await first.page.waitForFunction((n) => document.querySelectorAll('[aria-label="Sessions"] tbody tr').length === n, 3);
      const text = await rows.first().textContent();
      // Another page of the studio ends the session of this one.
      await second.page.getByRole('link', { name: 'Stage' }).click();
      await first.page.waitForFunction((n) => document.querySelectorAll('[aria-label="Sessions"] tbody tr').length === n, 2);
      const left = await count();
      await first.context.close();
      await second.context.close();
      return [
        ...first.errors,
        ...second.errors,
        ...unless(/knight/.test(text), `a row: ${text}`),
        ...unless(left === 2, `${left} sessions`),
        ...unless(scenes.length === 2 && scenes[0].x === 0 && scenes[1].x > 1 && scenes[1].bytes <= whole.bytes, `${JSON.stringify(scenes)} of ${whole.bytes}`),
      ];
    },
  },
  {
    name: 'an item is offered to the server, and Stream shows it once it is there',
    async run({ browser }) {
      const { context, page, errors } = await open(browser, '');
      const zip = { name: 'knight.zip', mimeType: 'application/zip', buffer: Buffer.from('PK manifest.json') };
      const send = async () => {
        await page.locator('.top input[type=file]').setInputFiles(zip);
        await page.getByRole('button', { name: 'Send it to the server' }).click();
      };
      // The server opens what it is given, and this is no item.
      await send();
      await page.getByRole('alert').filter({ hasText: 'knight: the server answers 4' }).waitFor();
      // What it would answer to one: the character of this name is there.
      let sent = 0;
      await page.route('**/v1/characters/knight', (route) => {
        sent += route.request().method() === 'PUT' && route.request().postDataBuffer().equals(zip.buffer) ? 1 : 0;
        return route.fulfill({ status: 202, contentType: 'application/json', body: '{}' });
      });
      await send();
      await reached(page, 'complete');
      const { page: shown, character } = await page.evaluate(() => globalThis.articulaStudio.studio.state);
      await context.close();
      const refused = errors.filter((error) => !/status of 4\d\d/.test(error));
      return [...refused, ...unless(sent === 1 && shown === 'stream' && character === 'knight', `sent ${sent}, shows ${shown} of ${character}`)];
    },
  },
];

const ALONE = {
  name: 'the page Stream says that there is no server',
  async run({ browser, server }) {
    const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stream' });
    await page.getByText('These pages come from a server without characters.').waitFor();
    const faults = await axe(page);
    await context.close();
    return [...faults, ...errors];
  },
};

if (PROGRAM === undefined) {
  console.log('skipped: streams of the studio, no program (build it, or set ARTICULA to it)');
}

export const STREAMS = PROGRAM === undefined ? [ALONE] : [ALONE, ...TESTS];
