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

const CAPTIONS = `WEBVTT

${CLIP}
00:00.000 --> 00:00.400
Here I <b>come</b>.

${CLIP}
00:00.000 --> 00:00.300
one.png

${CLIP}
00:00.300 --> 00:30.000
two.png

another clip
00:00.000 --> 00:30.000
Never said.
`;

/** A WAV file of silence. */
function silence(secs) {
  const [rate, bytes] = [8000, Buffer.alloc(44 + secs * 16_000)];
  bytes.write('RIFF', 0);
  bytes.writeUInt32LE(bytes.length - 8, 4);
  bytes.write('WAVEfmt ', 8);
  [[16, 16, 4], [20, 1, 2], [22, 1, 2], [24, rate, 4], [28, 2 * rate, 4], [32, 2, 2], [34, 16, 2], [40, bytes.length - 44, 4]].forEach(([at, value, width]) => bytes.writeUIntLE(value, at, width));
  bytes.write('data', 36);
  return bytes;
}

/** A PNG of so many pixels in a row, made by a browser. */
async function row(browser, width) {
  const page = await browser.newPage();
  const made = await page.evaluate((pixels) => {
    const canvas = Object.assign(document.createElement('canvas'), { width: pixels, height: 1 });
    canvas.getContext('2d').fillRect(0, 0, pixels, 1);
    return canvas.toDataURL('image/png').split(',')[1];
  }, width);
  await page.close();
  return Buffer.from(made, 'base64');
}

TESTS.push({
  name: 'sound, captions and pictures that an item carries go by the clock of its clip',
  async run({ browser }) {
    const carried = { 'talk.vtt': CAPTIONS, 'talk.wav': silence(2), 'one.png': await row(browser, 1), 'two.png': await row(browser, 2) };
    const guide = await openStore(KNIGHT, CLIP, 'guide', ['--studio', DIST], carried);
    try {
      const { context, page, errors } = await openStudio(browser, guide.url.replace(/\/$/, ''), { hash: '#stream', path: PATH, width: 1280, height: 800 });
      await page.evaluate(() => globalThis.articulaStudio.viewport.run(true));
      await reached(page, 'complete');
      await page.waitForFunction(() => globalThis.articulaStudio.current.stream.carried.every(({ file }) => globalThis.articulaStudio.current.stream.carriedFile(file) !== undefined));
      // From here on frames are made one by one.
      const at = (secs) => page.evaluate(async ([to, clip]) => {
        const { current, viewport } = globalThis.articulaStudio;
        viewport.run(false);
        current.stream.play(clip, to);
        viewport.advance(0);
        viewport.advance(0);
        const slide = document.querySelector('.slide');
        await slide.decode().catch(() => undefined);
        const caption = document.querySelector('.caption');
        return {
          secs: current.stream.clipSecs,
          heard: current.carried.sound.audio.currentTime,
          slide: slide.hidden ? 0 : slide.naturalWidth,
          alt: slide.alt,
          caption: caption.hidden ? '' : caption.textContent,
        };
      }, [secs, CLIP]);
      const [first, then] = [await at(0.1), await at(0.5)];
      const sound = await page.getByRole('button', { name: 'Sound', exact: true }).isVisible();
      const faults = await axe(page);
      await at(0.1);
      await page.screenshot({ path: fileURLToPath(new URL('stream-carried.png', OUT)) });
      // While the clip goes on, it is heard.
      await page.mouse.click(300, 300);
      const plays = await page.evaluate(async () => {
        const { current, viewport } = globalThis.articulaStudio;
        viewport.advance(0.01);
        viewport.advance(0.01);
        await new Promise((resolve) => setTimeout(resolve, 0));
        return !current.carried.sound.audio.paused;
      });
      await page.getByRole('link', { name: 'Stage' }).click();
      const isSilent = await page.evaluate(() => [...document.querySelectorAll('.slide, .caption')].length === 0);
      await context.close();
      return [
        ...faults,
        ...errors,
        ...unless(first.slide === 1 && first.alt === 'one' && first.caption === 'Here I come.', JSON.stringify(first)),
        ...unless(then.slide === 2 && then.alt === 'two' && then.caption === '', JSON.stringify(then)),
        ...unless([first, then].every(({ secs, heard }) => Math.abs(heard - secs) < 0.05) && then.secs - first.secs > 0.3, `heard at ${first.heard} and ${then.heard} s of ${first.secs} and ${then.secs}`),
        ...unless(sound && plays && isSilent, `sound: ${sound}, plays: ${plays}, silent elsewhere: ${isSilent}`),
      ];
    } finally {
      await guide.close();
    }
  },
});

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
