// The page Stage: what is shown is recorded, with camera, level and face, and the page Flat makes a picture of it.
import { readFile } from 'node:fs/promises';

import { axe, draw, openStudio, slide } from './page.mjs';

const OUT = new URL('./out/', import.meta.url);
const unless = (right, fault) => (right ? [] : [fault]);
const FRAMES = 12;

/** Heights of the head in the picture, frame by frame, while the camera steps back, or where it stands while the clip is shown again. */
const heights = (page, isAgain) => page.evaluate(([frames, stands]) => {
  const { viewport, current, studio } = globalThis.articulaStudio;
  return Array.from({ length: frames }, (_, frame) => {
    if (stands) {
      current.seek((frame + 1) / 25);
    } else {
      viewport.controls.target.set(0, 1, 0);
      viewport.camera.position.set(0, 1, 4 + frame / 3);
      viewport.advance(1 / 25);
    }
    const [{ figure }] = current.columns;
    const rows = current.columns[0].joints();
    viewport.camera.updateMatrixWorld();
    figure.updateWorldMatrix(true, false);
    const head = 12 * studio.character.asset.joints.indexOf('skullbase');
    const at = viewport.camera.position.clone().set(rows[head + 3], rows[head + 7], rows[head + 11]);
    return figure.localToWorld(at).project(viewport.camera).y;
  });
}, [FRAMES, isAgain]);

export const RECORDING = [
  {
    name: 'what is shown is recorded with camera, level and face, and becomes a picture',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?clip=walk&transition=0', width: 1280, height: 800 });
      await page.locator('summary', { hasText: /^Recording$/ }).click();
      await page.evaluate(() => globalThis.articulaStudio.viewport.place('0,1,4,0,1,0'));
      await page.getByRole('button', { name: 'Record what is shown' }).click();
      const first = await heights(page, false);
      // From here on no joint moves, and the mouth is open.
      await slide(page, 'Level of articulation', 1);
      await slide(page, 'jawOpen', 1);
      await page.evaluate(() => {
        for (let frame = 0; frame < 5; frame += 1) {
          globalThis.articulaStudio.viewport.advance(1 / 25);
        }
      });
      await page.getByRole('button', { name: 'Stop recording' }).click();
      await page.getByText('shown-1 is a clip of human.glb').waitFor({ timeout: 30_000 });
      await slide(page, 'Level of articulation', 0);
      const { clip, camera, still, jaw } = await page.evaluate(() => {
        const { current, studio, viewport } = globalThis.articulaStudio;
        // Its tables are not needed for a picture.
        studio.task.cancel();
        viewport.advance(0);
        const [hip, ankle] = ['l_hip', 'l_ankle'].map((name) => 12 * studio.character.asset.joints.indexOf(name));
        // How far the leg is stretched: the root goes on at all levels.
        const at = (secs) => {
          current.seek(secs);
          const [column] = current.columns;
          const rows = column.joints();
          const leg = Math.hypot(...[3, 7, 11].map((i) => rows[hip + i] - rows[ankle + i]));
          return { leg, jaw: Math.max(...column.figure.mesh.morphTargetInfluences) };
        };
        const [early, late] = [at(13 / 25), at(16 / 25)];
        return { clip: studio.state.clip, camera: viewport.pose, still: Math.abs(early.leg - late.leg) < 1e-4 && Math.abs(early.leg - at(5 / 25).leg) > 0.005, jaw: late.jaw };
      });
      const shown = await heights(page, true);
      const off = Math.max(...first.map((y, i) => Math.abs(y - shown[i])));
      await page.getByRole('link', { name: 'Flat' }).click();
      await page.evaluate(() => globalThis.articulaStudio.studio.set({ triangles: 100 }));
      const seen = await page.getByText('Seen by the camera with which its recording began.').isVisible();
      await page.getByRole('button', { name: 'Make the picture' }).click();
      await page.locator('.flat-picture img').waitFor({ timeout: 60_000 });
      await draw(page);
      const faults = await axe(page);
      await page.screenshot({ path: new URL('flat-recorded.png', OUT).pathname });
      const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download' }).click()]);
      const svg = await readFile(await saved.path(), 'utf8');
      await context.close();
      return [
        ...faults,
        ...errors,
        ...unless(clip === 'shown-1' && /^0,1,4,0,1,0$/.test(camera), `${clip} by ${camera}`),
        ...unless(off < 0.01 && Math.max(...first) - Math.min(...first) > 0.15, `the head is ${off} of the picture off: ${shown} in place of ${first}`),
        ...unless(still && jaw > 0.99, `still: ${still}, jaw ${jaw}`),
        ...unless(seen && /<svg/.test(svg), 'no picture by its camera'),
      ];
    },
  },
];
