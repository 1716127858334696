// The camera of the page Stage: its path is recorded, read by the program, dropped and replayed; where it stands is in the link.
import { readFile } from 'node:fs/promises';

import { column, jointsOf, openStudio, slide, step } from './page.mjs';

const FRAMES = 60;
const SECS = 1 / 30;
const HUMAN = new URL('../dist/human.glb', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);
const far = (a, b) => Math.hypot(...a.map((x, i) => x - b[i]));

/** Moves the camera on a line with a corner while frames go by; returns where it was and how far from the root, frame by frame. */
const move = (page) => page.evaluate(([frames, secs]) => {
  const { viewport, current } = globalThis.articulaStudio;
  return Array.from({ length: frames }, (_, frame) => {
    const there = Math.min(frame, 30) / 30;
    viewport.controls.target.set(0, 1, 0);
    viewport.camera.position.set(there, 1.5, 9 - frame / 10);
    viewport.advance(secs);
    const [{ figure }] = current.columns;
    const rows = current.columns[0].joints();
    const root = figure.localToWorld(viewport.camera.position.clone().set(rows[3], rows[7], rows[11]));
    return { eye: viewport.camera.position.toArray(), metres: root.distanceTo(viewport.camera.position) };
  });
}, [FRAMES, SECS]);

const eye = (page) => page.evaluate(() => globalThis.articulaStudio.viewport.camera.position.toArray());
const open = (page) => page.locator('summary', { hasText: 'Camera path' }).click();

export const CAMERA = [
  {
    name: 'a camera path is recorded as the program reads it, and replayed from a file',
    needs: 'native',
    async run({ browser, server, programs }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?turn=90&nearer=-1' });
      await open(page);
      await page.evaluate(() => globalThis.articulaStudio.viewport.place('0,1.5,9,0,1,0'));
      await page.getByRole('button', { name: 'Record' }).click();
      const moved = await move(page);
      await page.getByRole('button', { name: 'Stop recording' }).click();
      const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Save' }).click()]);
      const text = await readFile(await saved.path(), 'utf8');
      const keys = JSON.parse(text);
      const seen = programs.along(await readFile(HUMAN), text, '--clip', 'walk');
      const metres = moved.map((frame) => frame.metres);
      const faults = [
        ...unless(saved.suggestedFilename() === 'human-camera.json', saved.suggestedFilename()),
        ...unless(keys.length > 2 && keys.length < FRAMES, `${keys.length} keys of ${FRAMES} frames`),
        ...unless(Math.abs(seen.distance_m_max - Math.max(...metres)) < 0.03 && Math.abs(seen.distance_m_min - Math.min(...metres)) < 0.03, `${seen.distance_m_min} to ${seen.distance_m_max} m, here ${Math.min(...metres)} to ${Math.max(...metres)}`),
      ];
      await context.close();

      // A path that is dropped on another page opens the one that replays it.
      const again = await openStudio(browser, server.address, { hash: '#flat?turn=90&nearer=-1' });
      await again.page.locator('.top input[type=file]').setInputFiles({ name: 'path.json', mimeType: 'application/json', buffer: Buffer.from(text) });
      await again.page.getByText(`${keys.length} keys over`).waitFor();
      faults.push(...unless(/^#stage/.test(await again.page.evaluate(() => new URL(globalThis.articulaStudio.studio.permalink()).hash)), 'Stage is not shown'));
      await again.page.getByRole('button', { name: 'Replay' }).click();
      for (const frames of [20, 25]) {
        await step(again.page, frames, SECS);
        const at = frames === 20 ? 19 : 44;
        const off = far(await eye(again.page), moved[at].eye);
        faults.push(...unless(off < 0.01, `frame ${at} is ${off} m off`));
      }
      await step(again.page, 30, SECS);
      faults.push(...unless(await again.page.getByRole('button', { name: 'Replay' }).isEnabled(), 'it does not end'));
      await again.page.locator('.top input[type=file]').setInputFiles({ name: 'bent.json', mimeType: 'application/json', buffer: Buffer.from('[{"t": 0, "eye": [0, 1], "target": [0, 0, 0]}]') });
      await again.page.getByRole('alert').filter({ hasText: 'bent.json: [0].eye' }).waitFor();
      await again.context.close();
      return [...faults, ...errors, ...again.errors];
    },
  },
  {
    name: 'clones share geometry and have joints of their own, and a link holds camera and place',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?transition=0' });
      await page.locator('summary', { hasText: 'Placement' }).click();
      await slide(page, 'Clones', 3);
      await slide(page, 'Turned by', 90);
      await slide(page, 'To the right', 1.5);
      await slide(page, 'Level of articulation', 3);
      await step(page, 2, SECS);
      const crew = await page.evaluate(() => globalThis.articulaStudio.current.columns[0].crew.map(({ mesh, core }) => ({ geometry: mesh.geometry.uuid, active: core.jointStates.reduce((sum, s) => sum + (s === 1 ? 1 : 0), 0), bones: mesh.skeleton.uuid })));
      const low = (await jointsOf(page, 'loa(Low)')).length;
      const faults = [
        ...unless(crew.length === 4 && new Set(crew.map(({ geometry }) => geometry)).size === 1, `${crew.length} figures of ${new Set(crew.map(({ geometry }) => geometry)).size} geometries`),
        ...unless(new Set(crew.map(({ bones }) => bones)).size === 4 && crew.every(({ active }) => active === low), `joints: ${crew.map(({ active }) => active)}, Low has ${low}`),
      ];
      // Dragging moves it over the floor, and not the camera.
      const stood = { eye: await eye(page), box: await page.locator('canvas.picture').boundingBox() };
      await page.getByLabel('Dragging the picture moves the character').check();
      const [x, y] = [stood.box.x + 0.5 * stood.box.width, stood.box.y + 0.8 * stood.box.height];
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + 40, y, { steps: 4 });
      await page.mouse.up();
      await page.mouse.move(x, y);
      const { across, nearer } = await page.evaluate(() => ({ ...globalThis.articulaStudio.studio.state }));
      faults.push(...unless(across > 1.6 && nearer !== 0 && far(await eye(page), stood.eye) === 0, `dragged to ${across}, ${nearer} m`));
      await page.getByLabel('Dragging the picture moves the character').uncheck();
      await slide(page, 'To the front', 0);
      await slide(page, 'To the right', 1.5);
      await page.locator('canvas.picture').focus();
      await page.mouse.move(200, 250);
      await page.mouse.wheel(0, 300);
      await page.waitForFunction(() => !globalThis.articulaStudio.viewport.isFitted);
      await step(page, 45, SECS);
      const link = await page.evaluate(() => globalThis.articulaStudio.studio.permalink());
      const before = { eye: await eye(page), states: (await column(page)).states };
      await page.goto('about:blank');
      await page.goto(link);
      await page.waitForFunction(() => globalThis.articulaStudio?.frames > 1);
      await page.evaluate(() => globalThis.articulaStudio.viewport.run(false));
      await step(page, 2, SECS);
      const { root, count } = await page.evaluate(() => {
        const [{ root, crew }] = globalThis.articulaStudio.current.columns;
        return { root: [root.position.x, root.rotation.y], count: crew.length };
      });
      const off = far(await eye(page), before.eye);
      faults.push(...unless(/camera=/.test(link) && off < 0.01, `the camera of the link is ${off} m off: ${link}`));
      faults.push(...unless(count === 4 && root[0] === 1.5 && Math.abs(root[1] - Math.PI / 2) < 1e-6, `${count} figures at ${root}`));
      await context.close();
      return [...faults, ...errors];
    },
  },
];
