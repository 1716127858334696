import { button, section } from '../ui/controls.js';
import { download, h } from '../ui/dom.js';
import { baseOf } from '../files.js';
import type { Viewport } from '../view/viewport.js';
import type { Studio } from '../studio.js';
import { profile } from './levels.js';

/** What the visitor takes along: the prepared file, the motion, the level of articulation, the picture and the address of this view. */
export function takeHome(studio: Studio, viewport: Viewport): HTMLElement {
  const base = (): string => baseOf(studio.character.name);
  const glb = button('Prepared GLB', () => {
    studio.prepared().then(
      ({ bytes }) => download(bytes, `${base()}-prepared.glb`, 'model/gltf-binary'),
      (error: unknown) => studio.notices.fault(error),
    );
  });
  const loa = button('LoA profile', () => download(`${profileOf(studio)}\n`, `${base()}-loa.json`, 'application/json'));
  const motion = button('Motion (ABP)', () => void saveMotion(studio, base()));
  const picture = button('Picture (PNG)', () => {
    viewport.picture().then(
      (png) => download(png, `${base()}.png`, 'image/png'),
      (error: unknown) => studio.notices.fault(error),
    );
  });
  const link = button('Copy link', () => {
    navigator.clipboard.writeText(studio.permalink()).then(
      () => studio.notices.say('The link holds everything but the file.'),
      () => studio.notices.fault(`The clipboard is closed to this page. The link is ${studio.permalink()}`),
    );
  });
  const note = h('p', { class: 'hint' }, 'The program reads the profile: articula convert in.glb out.glb --loa-profile loa.json.');
  return section('Take home', false, h('div', { class: 'buttons' }, glb, motion, loa, picture, link), note);
}

/** Saves the clip that plays as body animation parameters, all joints of it. */
async function saveMotion({ articula, character, notices, state, task }: Studio, base: string): Promise<void> {
  const { bytes, name, asset } = character;
  const clip = asset.clips.includes(state.clip) ? state.clip : asset.clips[0];
  try {
    if (clip === undefined) {
      throw new Error(`${name}: the file has no clip`);
    }
    const abp = await task.run(`Writing ${clip}`, (watch) => articula.tools.convert(bytes, name, 'abp', { clip, ...watch }));
    download(abp, `${base}-${clip.replaceAll(/[^\w-]/g, '-')}.abp`, 'application/octet-stream');
  } catch (error) {
    notices.fault(error);
  }
}

/** The profile of the joints chosen now; those of an expression are listed by their names. */
function profileOf(studio: Studio): string {
  const { expression, metric } = studio.state;
  if (expression === '') {
    return profile(studio.state);
  }
  const { core, joints } = studio.character.asset;
  const plus = [...core.jointsOfExpression(expression)].map((joint) => joints[joint] ?? '');
  return JSON.stringify({ manual: metric === 'none', rule: 'sum', zones: [], joints: { plus, minus: [] } }, null, 2);
}
