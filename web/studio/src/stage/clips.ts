import { button, section, toggle } from '../ui/controls.js';
import { h, inBytes } from '../ui/dom.js';
import type { Studio } from '../studio.js';

/** The clips of the character with what they move and weigh; the one that plays is marked. */
export class ClipsPanel {
  readonly element: HTMLElement;
  readonly #studio: Studio;
  readonly #list = h('div', { class: 'clips', role: 'radiogroup', 'aria-label': 'Clips' });

  constructor(studio: Studio) {
    this.#studio = studio;
    const own = button('Move only the joints of this clip', () => this.#selectOwn(), 'small');
    const always = toggle('Choosing one does so', studio.state.own, (on) => studio.set({ own: on }));
    this.element = section('Clips', true, this.#list, h('div', { class: 'buttons' }, own, always.element));
  }

  renew(): void {
    const { asset } = this.#studio.character;
    const bytes = asset.core.clipBytes;
    if (asset.clips.length === 0) {
      this.#list.replaceChildren(h('p', { class: 'hint' }, 'The file has no clip: the rest pose is shown. Drop a BVH file to move it.'));
      return;
    }
    const playing = asset.clips.includes(this.#studio.state.clip) ? this.#studio.state.clip : asset.clips[0];
    const rows = asset.clips.map((name, i) => {
      const joints = asset.core.clipJoints(i).length;
      const about = `${(asset.clipSecs[i] ?? 0).toFixed(2)} s · ${joints} ${joints === 1 ? 'joint' : 'joints'} · ${inBytes(bytes[i] ?? 0)}`;
      return h('button', { type: 'button', role: 'radio', 'aria-checked': name === playing, class: 'clip', onclick: () => this.#play(name) }, h('span', {}, name), h('small', {}, about));
    });
    this.#list.replaceChildren(...rows);
  }

  #play(name: string): void {
    this.#studio.set({ clip: name });
    if (this.#studio.state.own) {
      this.#selectOwn();
    }
    this.renew();
  }

  /** Makes the active joints those that the clip moves. */
  #selectOwn(): void {
    const { asset } = this.#studio.character;
    const clip = Math.max(asset.clips.indexOf(this.#studio.state.clip), 0);
    if (asset.clips.length > 0) {
      const own = new Set(asset.core.clipJoints(clip));
      const minus = asset.joints.filter((_, joint) => !own.has(joint));
      this.#studio.set({ expression: '', complexity: '', depth: 0, hanim: '', zones: '', plus: '', minus: minus.join(',') });
      this.#studio.dispatchEvent(new Event('selection'));
    }
  }
}
