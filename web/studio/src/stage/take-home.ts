import { button, section, toggle } from '../ui/controls.js';
import { download, h, inBytes } from '../ui/dom.js';
import { baseOf } from '../files.js';
import type { Viewport } from '../view/viewport.js';
import type { Studio } from '../studio.js';
import { profile } from './levels.js';

/**
 * What the visitor takes along: the prepared file, the motion, the level of articulation, the picture and the address of this view.
 * `active` is an expression of the active joints.
 */
export function takeHome(studio: Studio, viewport: Viewport, active: () => string): HTMLElement {
  const base = (): string => baseOf(studio.character.name);
  const glb = button('Prepared GLB', () => {
    studio.prepared().then(
      ({ bytes }) => download(bytes, `${base()}-prepared.glb`, 'model/gltf-binary'),
      (error: unknown) => studio.notices.fault(error),
    );
  });
  const loa = button('LoA profile', () => download(`${profileOf(studio)}\n`, `${base()}-loa.json`, 'application/json'));
  const said = h('p', { class: 'said', role: 'status' });
  const save = (to: Form): void => void saveMotion(studio, base(), to, active()).then(
    (text) => {
      said.textContent = text;
    },
    (error: unknown) => studio.notices.fault(error),
  );
  const alone = toggle('Motions of the active joints alone', studio.state.alone, (on) => studio.set({ alone: on }));
  const motions = h('div', { class: 'buttons' }, button('Motion (ABP)', () => save('abp')), button('Motion (GLB)', () => save('glb')));
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
  return section('Take home', false, h('div', { class: 'buttons' }, glb, loa, picture, link), alone.element, motions, said, note);
}

type Form = 'abp' | 'glb';
const TYPES: Readonly<Record<Form, string>> = { abp: 'application/octet-stream', glb: 'model/gltf-binary' };

/** Saves the clip that plays, of all joints or of the active ones, and returns what that saves. */
async function saveMotion({ articula, character, state, task }: Studio, base: string, to: Form, active: string): Promise<string> {
  const { bytes, name, asset } = character;
  const clip = asset.clips.includes(state.clip) ? state.clip : asset.clips[0];
  if (clip === undefined) {
    throw new Error(`${name}: the file has no clip`);
  }
  const { alone, passive } = state;
  return task.run(`Writing ${clip}`, async (watch) => {
    const write = (loa: object): Promise<Uint8Array> => articula.tools.convert(bytes, name, to, { clip, ...loa, ...watch });
    const whole = await write({});
    // What passive joints hold is one pose; the frame that they are held in while it plays is not known.
    const made = alone ? await write({ loa: active, passive: passive === 'rest' ? 'rest' : 'key-pose' }) : whole;
    download(made, `${base}-${clip.replaceAll(/[^\w-]/g, '-')}${alone ? '-active' : ''}.${to}`, TYPES[to]);
    const joints = asset.core.jointsOfExpression(active).length;
    return alone ? `${joints} of ${asset.joints.length} joints move: ${inBytes(made.length)} in place of ${inBytes(whole.length)}.` : `All joints move: ${inBytes(made.length)}.`;
  });
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
