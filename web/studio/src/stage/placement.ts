import { Plane, Ray, Vector2, Vector3 } from 'three';

import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';
import { section, slider, toggle } from '../ui/controls.js';
import type { Viewport } from '../view/viewport.js';

/** Most figures beside the first that share its geometry. */
export const MOST_CLONES = 8;

/** Where it may stand, metres to the right and to the front. */
const ACROSS = [-5, 5] as const;
const NEARER = [-20, 5] as const;
const within = (value: number, [least, most]: readonly [number, number]): number => Math.round(100 * Math.min(Math.max(value, least), most)) / 100;

/** Where the character stands, and how many stand beside it. */
export function placement(studio: Studio): HTMLElement {
  const { state } = studio;
  const set = (change: Partial<StudioState>): void => studio.set(change);
  const metres = (value: number): string => `${value.toFixed(1)} m`;
  const turn = slider({ label: 'Turned by', min: -180, max: 180, step: 5, value: state.turn, shown: (deg) => `${deg}°`, onInput: (deg) => set({ turn: deg }) });
  const across = slider({ label: 'To the right', min: ACROSS[0], max: ACROSS[1], step: 0.1, value: state.across, shown: metres, onInput: (m) => set({ across: m }) });
  const nearer = slider({ label: 'To the front', min: NEARER[0], max: NEARER[1], step: 0.1, value: state.nearer, shown: metres, onInput: (m) => set({ nearer: m }) });
  const clones = slider({
    label: 'Clones',
    min: 0,
    max: MOST_CLONES,
    step: 1,
    value: state.clones,
    shown: (n) => (n === 0 ? 'none' : `${n}`),
    hint: 'They share geometry and clips, and each has its own joints: the numbers above are those of the first.',
    onInput: (n) => set({ clones: n }),
  });
  const drag = toggle('Dragging the picture moves the character', state.drag, (on) => set({ drag: on }));
  studio.addEventListener('state', () => {
    across.set(studio.state.across);
    nearer.set(studio.state.nearer);
  });
  return section('Placement', false, turn.element, across.element, nearer.element, drag.element, clones.element);
}

/** Lets the pointer move the character of a page over the floor, while the state says so; the camera then stays. */
export function dragged(studio: Studio, viewport: Viewport, page: HTMLElement): void {
  const canvas = viewport.renderer.domElement;
  /** What the character is away from the point of the floor under the pointer. */
  let held: Vector2 | undefined;
  const free = (): void => {
    held = undefined;
  };
  studio.addEventListener('state', () => {
    if (viewport.isIn(page)) {
      viewport.controls.enabled = !studio.state.drag;
    }
  });
  canvas.addEventListener('pointerdown', (event) => {
    const { state } = studio;
    const floor = state.drag && viewport.isIn(page) ? floorAt(viewport, event) : undefined;
    if (floor !== undefined) {
      held = new Vector2(state.across, state.nearer).sub(floor);
      canvas.setPointerCapture(event.pointerId);
    }
  });
  canvas.addEventListener('pointermove', (event) => {
    const floor = held === undefined ? undefined : floorAt(viewport, event);
    if (held !== undefined && floor !== undefined) {
      const { x, y } = floor.add(held);
      studio.set({ across: within(x, ACROSS), nearer: within(y, NEARER) });
    }
  });
  canvas.addEventListener('pointerup', free);
  canvas.addEventListener('pointercancel', free);
}

/** The point of the floor under the pointer, metres to the right and to the front; undefined above the horizon. */
function floorAt(viewport: Viewport, { offsetX, offsetY }: PointerEvent): Vector2 | undefined {
  const { width, height } = viewport.columnSize;
  const at = new Vector2(((offsetX % width) / width) * 2 - 1, 1 - ((offsetY % height) / height) * 2);
  const ray = new Ray();
  ray.origin.setFromMatrixPosition(viewport.camera.matrixWorld);
  ray.direction.set(at.x, at.y, 0.5).unproject(viewport.camera).sub(ray.origin).normalize();
  const hit = ray.intersectPlane(new Plane(new Vector3(0, 1, 0), 0), new Vector3());
  return hit === null ? undefined : new Vector2(hit.x, hit.z);
}
