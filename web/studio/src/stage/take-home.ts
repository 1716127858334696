import { button, section } from '../ui/controls.js';
import { download, h } from '../ui/dom.js';
import { baseOf } from '../files.js';
import type { Studio } from '../studio.js';
import { profile } from './levels.js';

/** What the visitor takes along: the prepared file, the level of articulation, and the address of this view. */
export function takeHome(studio: Studio): HTMLElement {
  const base = (): string => baseOf(studio.character.name);
  const glb = button('Prepared GLB', () => {
    studio.prepared().then(
      ({ bytes }) => download(bytes, `${base()}-prepared.glb`, 'model/gltf-binary'),
      (error: unknown) => studio.notices.fault(error),
    );
  });
  const loa = button('LoA profile', () => download(`${profileOf(studio)}\n`, `${base()}-loa.json`, 'application/json'));
  const link = button('Copy link', () => {
    navigator.clipboard.writeText(studio.permalink()).then(
      () => studio.notices.say('The link holds everything but the file.'),
      () => studio.notices.fault(`The clipboard is closed to this page. The link is ${studio.permalink()}`),
    );
  });
  const note = h('p', { class: 'hint' }, 'The program reads the profile: articula convert in.glb out.glb --loa-profile loa.json.');
  return section('Take home', false, h('div', { class: 'buttons' }, glb, loa, link), note);
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
