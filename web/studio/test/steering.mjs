// Controls move, and joints, colours and figures follow.
import { readFile } from 'node:fs/promises';

import { column, draw, jointsOf, openFile, openStudio, slide, step } from './page.mjs';

const FAP = new URL('../../../assets/fap/speech_synthetic.fap', import.meta.url);
const [PASSIVE, ACTIVE, CHANGING] = [0, 1, 2];
const unless = (right, fault) => (right ? [] : [fault]);
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const inState = ({ states }, state) => states.flatMap((s, joint) => (s === state ? [joint] : []));
/** Which of red, green and amber a joint is painted in: green has the least red, amber more green than red has. */
const painted = ([r, g]) => (g > r ? ACTIVE : g < 0.2 ? PASSIVE : CHANGING);

/** Whether each joint is painted as it is. */
function paintFaults({ states, colors }, when) {
  const wrong = states.findIndex((state, joint) => painted(colors.slice(3 * joint, 3 * joint + 2)) !== state);
  return unless(wrong < 0, `${when}: joint ${wrong} is in state ${states[wrong]} and painted ${colors.slice(3 * wrong, 3 * wrong + 3)}`);
}

/** Notes of each picture, from the first on, how the joints stand and how many triangles are drawn. */
const watchFrames = () => {
  globalThis.pictures = [];
  Object.defineProperty(globalThis, 'articulaStudio', {
    configurable: true,
    set(hook) {
      Object.defineProperty(globalThis, 'articulaStudio', { value: hook, writable: true });
      const { step } = hook.viewport;
      hook.viewport.step = function (secs) {
        step.call(this, secs);
        const pose = hook.current?.columns?.[0]?.joints().slice().join();
        globalThis.pictures.push({ pose, triangles: this.renderer.info.render.triangles });
      };
    },
  });
};

export const STEERING = [
  {
    name: 'the first picture has a figure, and it moves with the next ones, by the play module alone',
    async run({ browser, server }) {
      const { context, page, errors, requests } = await openStudio(browser, server.address, { before: watchFrames });
      const pictures = await page.evaluate(() => globalThis.pictures.slice(0, 3));
      const asked = requests.map((url) => new URL(url).pathname.split('/').at(-1)).filter((name) => /\.(wasm|glb)$/.test(name));
      await context.close();
      const shown = pictures.filter(({ pose, triangles }) => pose !== undefined && triangles > 1000);
      return [
        ...errors,
        ...unless(shown.length === 3, `figures in ${shown.length} of the first three pictures`),
        ...unless(new Set(shown.map(({ pose }) => pose)).size > 1, 'it stands still in the first three pictures'),
        ...unless(asked.length === 2 && asked.some((name) => name.startsWith('play_bg')), `the first picture waits for ${asked}`),
      ];
    },
  },
  {
    name: 'a moving figure is shown before anything is chosen, and levels steer its joints',
    async run({ browser, server }) {
      const { context, page, errors, requests } = await openStudio(browser, server.address);
      const pose = () => page.evaluate(() => globalThis.articulaStudio.current.columns[0].joints().slice().join());
      const before = await pose();
      await step(page, 5, 1 / 30);
      const faults = [...unless(before !== (await pose()), 'the figure stands still')];
      const all = await column(page);
      faults.push(...unless(all.figures.passive === 0 && all.figures.active > 80, JSON.stringify(all.figures)));
      faults.push(...paintFaults(all, 'all joints'));
      await slide(page, 'Transition', 2);
      await step(page, 2, 1 / 30);
      await page.getByLabel('Level of articulation', { exact: true }).focus();
      for (let presses = 0; presses < 3; presses += 1) {
        await page.keyboard.press('ArrowRight');
      }
      await step(page, 3, 1 / 30);
      const amid = await column(page);
      faults.push(...unless(amid.figures.changing > 40, `in transition: ${JSON.stringify(amid.figures)}`), ...paintFaults(amid, 'in transition'));
      await step(page, 70, 1 / 30);
      const low = await column(page);
      const wanted = await jointsOf(page, 'loa(Low)');
      faults.push(...unless(same(inState(low, ACTIVE), wanted), `Low moves ${inState(low, ACTIVE)}, not ${wanted}`));
      faults.push(...unless(low.figures.changing === 0 && low.figures.updated === wanted.length, JSON.stringify(low.figures)));
      faults.push(...paintFaults(low, 'Low'));
      faults.push(...unless((await page.locator('#levels .said').textContent()).startsWith(`${wanted.length} of `), 'the count is not told'));
      const elsewhere = requests.filter((url) => !url.startsWith(server.address) && !url.startsWith('blob:'));
      faults.push(...unless(elsewhere.length === 0, `asks ${elsewhere}`));
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'every selector and metric steers, and a link holds them',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?transition=0' });
      const faults = [];
      const expect = async (expression, what) => {
        await step(page, 2, 1 / 30);
        const moved = inState(await column(page), ACTIVE);
        const wanted = await jointsOf(page, expression);
        faults.push(...unless(same(moved, wanted), `${what}: ${moved.length} joints move, ${wanted.length} are chosen`));
      };
      await slide(page, 'Depth below the root', 3);
      await expect('depth(3)', 'depth');
      await page.locator('.chips label', { hasText: 'hands' }).click();
      await expect('depth(3) + zone(hands)', 'depth and zone');
      await page.locator('.segmented label', { hasText: /^Intersection$/ }).click();
      await expect('depth(3) & zone(hands)', 'intersection');
      await page.locator('.segmented label', { hasText: /^Sum$/ }).click();
      await page.locator('.chips label', { hasText: 'hands' }).click();
      await slide(page, 'Depth below the root', 0);
      await page.getByLabel('H-Anim level').selectOption('1');
      await expect('hanim(1)', 'H-Anim level');
      await page.getByText('Single joints', { exact: true }).click();
      await page.getByLabel('Find a joint').fill('skullbase');
      await page.locator('.joint select').first().selectOption('minus');
      await expect('hanim(1) - joint(skullbase)', 'a single joint');
      await page.locator('summary', { hasText: 'Take home' }).click();
      const [saved] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'LoA profile' }).click()]);
      const profile = await readFile(await saved.path(), 'utf8');
      const [taken, wanted] = await page.evaluate((text) => {
        const { core } = globalThis.articulaStudio.studio.character.asset;
        return [[...core.jointsOfProfile(text)], [...core.jointsOfExpression('hanim(1) - joint(skullbase)')]];
      }, profile);
      faults.push(...unless(same(taken, wanted) && saved.suggestedFilename() === 'human-loa.json', `the profile ${profile} has the joints ${taken}`));
      const link = await page.evaluate(() => globalThis.articulaStudio.studio.permalink());
      await page.getByLabel('Expression, in place of the selectors').fill('loa(Low) + zone(');
      faults.push(...unless(await page.locator('#levels .field-fault').isVisible(), 'a mistake is not told'));
      await expect('hanim(1) - joint(skullbase)', 'a mistake in an expression');
      await page.getByLabel('Expression, in place of the selectors').fill('loa(Low) + zone(hands)');
      await expect('loa(Low) + zone(hands)', 'an expression');
      await page.getByLabel('Expression, in place of the selectors').fill('');
      await page.getByLabel('H-Anim level').selectOption('');
      // Metrics: a large tolerance and a large threshold hold joints, and the error is told.
      await page.locator('.segmented label', { hasText: /^Pixel error$/ }).click();
      await slide(page, 'Tolerance', 1.8);
      await step(page, 8, 1 / 30);
      const held = await column(page);
      const error = await page.evaluate(() => globalThis.articulaStudio.current.error);
      faults.push(...unless(held.figures.updated < 60, `64 px: ${JSON.stringify(held.figures)}`), ...unless(error[0] > 0 && error[1] >= error[0], `error ${error}`));
      await page.locator('.segmented label', { hasText: /^Threshold$/ }).click();
      await slide(page, 'Threshold at the viewer', 0);
      await slide(page, 'Threshold at 16 m', 0);
      await step(page, 8, 1 / 30);
      const thesis = await column(page);
      faults.push(...unless(thesis.figures.updated < 60, `threshold 1: ${JSON.stringify(thesis.figures)}`));
      await page.locator('.segmented label', { hasText: /^All levels$/ }).click();
      await step(page, 2, 1 / 30);
      const columns = await page.evaluate(() => globalThis.articulaStudio.current.columns.map((c) => c.figures().active));
      faults.push(...unless(columns.length === 7 && columns[0] === 0, `columns move ${columns}`));
      await page.goto('about:blank');
      await page.goto(link);
      await page.waitForFunction(() => globalThis.articulaStudio?.frames > 1);
      await expect('hanim(1) - joint(skullbase)', 'a link');
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'the clock plays, pauses, seeks and loops, by keyboard',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?playing=0&at=0.5' });
      const secs = () => page.evaluate(() => globalThis.articulaStudio.current.timeline.secs);
      const faults = [...unless((await secs()) === 0.5, `a link to 0.5 s shows ${await secs()} s`)];
      await step(page, 5, 0.1);
      faults.push(...unless((await secs()) === 0.5, 'it moves while it is paused'));
      // What stands still shows what its frame took.
      const { matrices, sampled } = (await column(page)).figures;
      faults.push(...unless(matrices > 0 && sampled > 0, `a paused frame tells ${matrices} matrices of ${sampled} transforms`));
      await page.getByLabel('Play', { exact: true }).focus();
      await page.keyboard.press('Enter');
      await step(page, 30, 1 / 30);
      const looped = await secs();
      faults.push(...unless(looped !== 0.5 && looped < 1.1, `after a second of a loop of 1.07 s: ${looped} s`));
      await page.getByRole('button', { name: 'Loop' }).click();
      await step(page, 40, 1 / 30);
      faults.push(...unless((await secs()) > 1.06 && (await page.getByLabel('Play', { exact: true }).isVisible()), `without a loop it ends at ${await secs()} s`));
      await page.getByRole('radio', { name: /idle/ }).click();
      await page.getByLabel('Play', { exact: true }).click();
      await step(page, 2, 0.1);
      const idle = await page.evaluate(() => globalThis.articulaStudio.studio.state.clip);
      faults.push(...unless(idle === 'idle', `the clip is ${idle}`));
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'a clip makes its own joints the active ones, and the view shows what it is told to',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#stage?transition=0' });
      await page.getByRole('radio', { name: /wave/ }).click();
      await page.getByRole('button', { name: 'Move only the joints of this clip' }).click();
      await step(page, 2, 1 / 30);
      const own = await page.evaluate(() => {
        const { asset } = globalThis.articulaStudio.studio.character;
        return [...asset.core.clipJoints(asset.clips.indexOf('wave'))];
      });
      const moved = inState(await column(page), ACTIVE);
      const faults = unless(same(moved, own) && own.length < 89, `${moved.length} joints move, the clip moves ${own.length}`);
      // From now on each clip that is chosen does so.
      await page.getByLabel('Choosing one does so', { exact: true }).check();
      await page.getByRole('radio', { name: /idle/ }).click();
      await step(page, 2, 1 / 30);
      const idle = await page.evaluate(() => {
        const { asset } = globalThis.articulaStudio.studio.character;
        return [...asset.core.clipJoints(asset.clips.indexOf('idle'))];
      });
      const still = inState(await column(page), ACTIVE);
      faults.push(...unless(same(still, idle) && !same(idle, own), `${still.length} joints move, idle moves ${idle.length}`));
      const looks = () => page.evaluate(() => {
        const [{ root, figure }] = globalThis.articulaStudio.current.columns;
        let joint;
        root.traverse((object) => {
          joint ??= object.isInstancedMesh ? object : undefined;
        });
        return { skeleton: joint.parent.visible, radius: joint.instanceMatrix.array[0], body: figure.mesh.visible, opacity: figure.mesh.material[0].opacity };
      });
      const before = await looks();
      await slide(page, 'Size of joints', 2);
      await step(page, 1, 0);
      faults.push(...unless(Math.abs((await looks()).radius / before.radius - 2) < 0.01 && before.opacity < 1, 'joints keep their size'));
      // Colours of states are chosen, and held by the link.
      await page.locator('.fold > summary', { hasText: 'Colours' }).click();
      await page.getByLabel('Active joints', { exact: true }).fill('#0000ff');
      await step(page, 1, 0);
      const blue = (await column(page)).colors;
      const link = await page.evaluate(() => globalThis.articulaStudio.studio.permalink());
      const [joint] = inState(await column(page), ACTIVE);
      const legend = await page.locator('.state-key .active').evaluate((key) => getComputedStyle(key, '::before').backgroundColor);
      faults.push(...unless(same(blue.slice(3 * joint, 3 * joint + 3), [0, 0, 1]) && legend === 'rgb(0, 0, 255)' && /activeColor=%230000ff/.test(link), `joint ${joint} is ${blue.slice(3 * joint, 3 * joint + 3)}, its legend ${legend}, the link ${link}`));
      await page.getByRole('button', { name: 'Usual colours' }).click();
      await step(page, 1, 0);
      const usual = await column(page);
      faults.push(...paintFaults(usual, 'usual colours'));
      await page.getByLabel('Skeleton', { exact: true }).uncheck();
      await page.getByLabel('Body', { exact: true }).selectOption('none');
      const after = await looks();
      faults.push(...unless(!after.skeleton && !after.body && after.opacity === 1, JSON.stringify(after)));
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'a motion of a face moves a character that had no blend shapes, and sliders add to it',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address);
      const name = await openFile(page, 'speech.fap', await readFile(FAP));
      const weights = (secs) => page.evaluate((at) => {
        const { current } = globalThis.articulaStudio;
        current.seek(at);
        return [...current.columns[0].figure.mesh.morphTargetInfluences];
      }, secs);
      const { clip, faces } = await page.evaluate(() => {
        const { studio } = globalThis.articulaStudio;
        return { clip: studio.state.clip, faces: studio.character.asset.expressions.length };
      });
      const faults = unless(name === 'human.glb' && clip === 'speech' && faces > 40, `${name} plays ${clip} with ${faces} expressions`);
      const [still, spoken] = [await weights(0), await weights(3)];
      faults.push(...unless(!same(still, spoken) && spoken.some((weight) => weight > 0.05), `weights ${spoken}`));
      await page.locator('summary', { hasText: /^Face$/ }).click();
      await slide(page, 'jawOpen', 1);
      const open = await weights(3);
      faults.push(...unless(Math.max(...open.map((weight, i) => weight - (spoken[i] ?? 0))) > 0.99, `jawOpen at 1 gives ${open}`));
      await context.close();
      return [...faults, ...errors];
    },
  },
  {
    name: 'a crowd keeps its tolerance, and its tiers are told',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#crowd?count=100&tolerance=4' });
      await page.waitForFunction(() => globalThis.articulaStudio.current.crowd !== undefined);
      const tiers = () => page.evaluate(() => [...document.querySelectorAll('.tiers b')].map((b) => Number(b.textContent)));
      const levels = () => page.evaluate(() => {
        const { crowd } = globalThis.articulaStudio.current;
        return Array.from({ length: crowd.core.levels }, (_, level) => Array.from({ length: crowd.count }, (_, i) => crowd.levelOf(i)).filter((l) => l === level).length);
      });
      await draw(page);
      await step(page, 13, 1 / 30);
      const coarse = await levels();
      const faults = [...unless(same(await tiers(), coarse), `told ${await tiers()}, shown ${coarse}`), ...unless(coarse[0] < 50, `at 4 px ${coarse[0]} are full`)];
      await page.locator('.segmented label', { hasText: /^All joints$/ }).click();
      await draw(page);
      await step(page, 13, 1 / 30);
      const full = await levels();
      faults.push(...unless(full[0] > 0 && full.slice(1).every((n) => n === 0), `all joints: ${full}`));
      const told = await page.locator('.readout').first().textContent();
      faults.push(...unless(/Triangles drawn[1-9]/.test(told), told));
      await context.close();
      return [...faults, ...errors];
    },
  },
];
