// Files that are opened: a voice is spoken and heard, what is nothing to the studio is told.
import { readFile } from 'node:fs/promises';

import { openFile, openStudio, step } from './page.mjs';

const VOICE = new URL('../../../assets/speech/librivox_austen_0880.wav', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);

/** Gives the page a file by its picker. */
const give = (page, name, text) => page.locator('.top input[type=file]').setInputFiles({ name, mimeType: 'application/octet-stream', buffer: Buffer.from(text) });

/** Drops a file onto the middle of the page. */
const drop = (page, name, text) => page.evaluate(([file, content]) => {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([content], file));
  document.body.dispatchEvent(new DragEvent('dragenter', { dataTransfer, bubbles: true, cancelable: true }));
  document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
}, [name, text]);

export const DROPS = [
  {
    name: 'a recording is spoken by the face, and heard on the clock of the clip',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?playing=0' });
      const wav = await readFile(VOICE);
      await openFile(page, 'austen.wav', wav);
      await page.getByText('human.glb speaks austen.wav').waitFor();
      const secs = (wav.length - 44) / 2 / wav.readUInt32LE(24);
      const { clip, length } = await page.evaluate(() => {
        const { current, studio } = globalThis.articulaStudio;
        const { asset } = studio.character;
        current.timeline.pause();
        return { clip: studio.state.clip, length: asset.clipSecs[asset.clips.indexOf(studio.state.clip)] };
      });
      const mouth = (at) => page.evaluate((moment) => {
        const { current } = globalThis.articulaStudio;
        current.seek(moment);
        return { weights: [...current.columns[0].figure.mesh.morphTargetInfluences], heard: current.voice.audio.currentTime };
      }, at);
      const moments = [];
      for (const at of [0, 0.6, 1.2]) {
        moments.push(await mouth(at));
      }
      const opens = moments.map(({ weights }) => Math.max(...weights));
      await page.getByLabel('Play', { exact: true }).click();
      await step(page, 1, 1 / 30);
      const plays = await page.waitForFunction(() => !globalThis.articulaStudio.current.voice.audio.paused).then(() => true, () => false);
      await page.getByRole('button', { name: 'Sound', exact: true }).click();
      await step(page, 1, 1 / 30);
      const isSilent = await page.evaluate(() => globalThis.articulaStudio.current.voice.audio.paused);
      await page.getByRole('radio', { name: /walk/ }).click();
      await step(page, 1, 1 / 30);
      const faults = [
        ...unless(clip === 'austen' && Math.abs(length - secs) < 1 / 30, `the clip ${clip} takes ${length} s of ${secs} s`),
        ...unless(moments.some(({ weights }) => weights.some((w) => w > 0.1)) && new Set(opens).size > 1, `weights at most ${opens}`),
        ...unless(moments.every(({ heard }, i) => Math.abs(heard - [0, 0.6, 1.2][i]) < 0.01), `heard at ${moments.map(({ heard }) => heard)} s`),
        ...unless(plays && isSilent, `plays: ${plays}, silent after Sound: ${isSilent}`),
        ...unless(await page.getByRole('button', { name: 'Sound', exact: true }).isHidden(), 'Sound is offered for a clip without one'),
      ];
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'items and files that are nothing to the studio are told, picked or dropped',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address);
      const told = (text) => page.locator('.notice').filter({ hasText: text }).waitFor();
      await give(page, 'notes.txt', 'not a character');
      await told('notes.txt: the studio knows no such file. It opens GLB');
      await drop(page, 'song.mp3', 'not a voice');
      await told('A voice is a WAV file: ffmpeg -i song.mp3 voice.wav');
      await drop(page, 'noise.wav', 'not a voice');
      await told('noise.wav: not a WAV file');
      await drop(page, 'pictures.zip', 'PK');
      await told('pictures.zip: a ZIP file without a manifest.json is no digital item');
      await drop(page, 'hero.zip', 'PK hero/manifest.json');
      await told('hero.zip is a digital item, which a server shows');
      const offers = await page.getByRole('button', { name: 'Send it to the server' }).count();
      const { name } = await page.evaluate(() => globalThis.articulaStudio.studio.character);
      await context.close();
      return [...errors, ...unless(offers === 0 && name === 'human.glb', `${offers} offers; shows ${name}`)];
    },
  },
];
