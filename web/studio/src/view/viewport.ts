import {
  ACESFilmicToneMapping,
  type Box3,
  Color,
  DirectionalLight,
  GridHelper,
  HemisphereLight,
  type Object3D,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { h } from '../ui/dom.js';

/** Vertical field of view in degrees, that of the evaluations. */
const FOV_DEG = 45;
/** Share of the picture's height that a character fills, and its width by its height with room for arms. */
const FILLED = 0.74;
export const WIDTH_TO_HEIGHT = 0.46;
/** Least height that is fitted. */
const LEAST_METRES = 0.2;
/** Longest step of a frame in seconds, after the page was hidden. */
const MAX_STEP_SECS = 0.1;

/** What is shown in a column of the picture. */
export interface Column {
  readonly root: Object3D;
}

/** A picture of three.js that pages share, with its camera, its lights and its frames. */
export class Viewport {
  readonly element: HTMLElement;
  readonly renderer: WebGLRenderer;
  readonly scene = new Scene();
  readonly camera = new PerspectiveCamera(FOV_DEG, 1, 0.05, 500);
  readonly controls: OrbitControls;
  /** Called before each frame with its step in seconds. */
  onFrame: (dtSecs: number) => void = () => {};
  /** Columns, each with what is seen in it alone; without any, all is seen in one. */
  columns: readonly Column[] = [];
  /** Frames that were drawn. */
  frames = 0;
  readonly #lost = h('div', { class: 'overlay-note', role: 'alert', hidden: true }, 'The graphics context was lost. It comes back by itself, or with a reload.');
  #last = 0;
  /** What the picture is fitted to, until the visitor moves the camera. */
  #fitted: readonly [Box3, number, number, number] | undefined;
  #width = 1;
  #height = 1;

  /** Throws where WebGL 2 is missing. */
  constructor() {
    const canvas = h('canvas', { class: 'picture', 'aria-label': 'Character. Drag to turn, scroll to zoom, arrow keys to move.', role: 'img', tabindex: 0 });
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.element = h('div', { class: 'viewport' }, canvas, this.#lost);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.controls.minDistance = 0.3;
    this.controls.maxDistance = 150;
    this.controls.listenToKeyEvents(canvas);
    this.controls.addEventListener('start', () => {
      this.#fitted = undefined;
    });
    const sun = new DirectionalLight(0xffffff, 2.6);
    sun.position.set(2, 4, 3);
    const rim = new DirectionalLight(0xbfd4ff, 1.1);
    rim.position.set(-3, 2, -4);
    this.scene.add(new HemisphereLight(0xffffff, 0x8d8a80, 1.7), sun, rim);
    this.#addFloor();
    canvas.addEventListener('webglcontextlost', () => {
      this.#lost.hidden = false;
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.#lost.hidden = true;
    });
    new ResizeObserver(() => {
      if (this.measure()) {
        this.step(0);
      }
    }).observe(this.element);
    this.run(true);
  }

  /** Shows itself in the frame of a page, its first element, and tells it of each picture. */
  showIn(page: HTMLElement, onFrame: (dtSecs: number) => void): void {
    (page.firstElementChild as HTMLElement).prepend(this.element);
    this.measure();
    this.onFrame = onFrame;
  }

  /** Whether it is shown in a page. */
  isIn(page: HTMLElement): boolean {
    return this.element.closest('.stage') === page;
  }

  /** How the columns lie: in two rows where one would make them too narrow. */
  get grid(): { across: number; rows: number } {
    const count = Math.max(this.columns.length, 1);
    const rows = count > 3 && this.#width < this.#height * 1.1 ? 2 : 1;
    return { across: Math.ceil(count / rows), rows };
  }

  /** Size of one column in pixels of the screen, for errors. */
  get columnSize(): { width: number; height: number } {
    const { across, rows } = this.grid;
    return { width: this.#width / across, height: this.#height / rows };
  }

  /**
   * Places the camera so that the height of a box fills a share of the picture, at a yaw from the front in radians. What is
   * shown is `wide` by its height.
   */
  fit(box: Box3, yaw: number, filled = FILLED, wide = WIDTH_TO_HEIGHT): void {
    const height = Math.max(box.max.y - box.min.y, LEAST_METRES);
    const distance = height / filled / 2 / Math.tan((FOV_DEG * Math.PI) / 360);
    const { width, height: pixels } = this.columnSize;
    const far = Math.max(distance, (distance * wide * pixels) / width);
    this.#fitted = [box, yaw, filled, wide];
    box.getCenter(this.controls.target);
    this.controls.target.y -= 0.02 * height;
    const direction = new Vector3(Math.sin(yaw), 0.12, Math.cos(yaw)).normalize();
    this.camera.position.copy(this.controls.target).addScaledVector(direction, far);
    this.controls.update();
  }

  /** Takes over the size of the element; false if it is that of before. */
  measure(): boolean {
    const { clientWidth, clientHeight } = this.element;
    if (clientWidth === 0 || clientHeight === 0 || (clientWidth === this.#width && clientHeight === this.#height)) {
      return false;
    }
    [this.#width, this.#height] = [clientWidth, clientHeight];
    this.renderer.setSize(clientWidth, clientHeight, false);
    if (this.#fitted !== undefined) {
      this.fit(...this.#fitted);
    }
    return true;
  }

  /** Whether the picture is fitted to a box: the visitor has not moved the camera. */
  get isFitted(): boolean {
    return this.#fitted !== undefined;
  }

  /** Where the camera is and looks: six numbers with commas between them. */
  get pose(): string {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()].map((x) => Number(x.toFixed(3))).join(',');
  }

  /** Places the camera at a {@link pose}; false if it is none. */
  place(pose: string): boolean {
    const numbers = pose.split(',').map(Number);
    if (numbers.length !== 6 || !numbers.every(Number.isFinite)) {
      return false;
    }
    this.leave();
    this.camera.position.fromArray(numbers);
    this.controls.target.fromArray(numbers, 3);
    this.controls.update();
    return true;
  }

  /** Looks from an eye at a target, as large as a square of a share of the height would show it. */
  see(eye: readonly [number, number, number], target: readonly [number, number, number], share: number): void {
    this.leave();
    this.controls.target.fromArray(target);
    this.camera.position.fromArray(eye).sub(this.controls.target).divideScalar(share).add(this.controls.target);
    this.controls.update();
  }

  /** Leaves the camera to the caller, whatever the size of the picture. */
  leave(): void {
    this.#fitted = undefined;
  }

  /** Whether frames follow the display; without, `advance` makes them one by one. */
  run(on: boolean): void {
    this.renderer.setAnimationLoop(on ? (ms) => this.#frame(ms) : null);
  }

  /** Goes on by seconds without drawing. */
  advance(dtSecs: number): void {
    this.controls.update();
    this.onFrame(dtSecs);
    this.frames += 1;
  }

  /** Goes on by seconds and draws. */
  step(dtSecs: number): void {
    this.advance(dtSecs);
    this.#draw();
  }

  /** What is shown now, as a PNG. */
  async picture(): Promise<Uint8Array> {
    this.step(0);
    // The picture is taken before the browser clears it.
    const blob = await new Promise<Blob | null>((resolve) => this.renderer.domElement.toBlob(resolve));
    if (blob === null) {
      throw new Error('the browser gives no picture of this canvas');
    }
    return new Uint8Array(await blob.arrayBuffer());
  }

  #frame(ms: number): void {
    const dt = Math.min((ms - this.#last) / 1000, MAX_STEP_SECS);
    this.#last = ms;
    if (this.element.isConnected && !this.renderer.getContext().isContextLost()) {
      this.step(dt);
    }
  }

  #draw(): void {
    const { renderer, scene, camera, columns } = this;
    renderer.info.autoReset = false;
    renderer.info.reset();
    if (columns.length < 2) {
      camera.aspect = this.#width / this.#height;
      camera.updateProjectionMatrix();
      renderer.setScissorTest(false);
      renderer.setViewport(0, 0, this.#width, this.#height);
      renderer.render(scene, camera);
      return;
    }
    const { across } = this.grid;
    const { width, height } = this.columnSize;
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    // Cells that no column fills stay empty.
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    columns.forEach((_, i) => {
      columns.forEach(({ root }, other) => {
        root.visible = other === i;
      });
      const [x, y] = [(i % across) * width, this.#height - (Math.floor(i / across) + 1) * height];
      renderer.setViewport(x, y, width, height);
      renderer.setScissor(x, y, width, height);
      renderer.render(scene, camera);
    });
    columns.forEach(({ root }) => {
      root.visible = true;
    });
  }

  #addFloor(): void {
    const dark = matchMedia('(prefers-color-scheme: dark)');
    let grid: GridHelper | undefined;
    const paint = (): void => {
      grid?.removeFromParent();
      grid?.dispose();
      const theme = document.documentElement.dataset.theme ?? (dark.matches ? 'dark' : 'light');
      const line = new Color(theme === 'dark' ? 0x39424d : 0xc3c9d1);
      grid = new GridHelper(24, 24, line, line);
      this.scene.add(grid);
    };
    paint();
    dark.addEventListener('change', paint);
    addEventListener('themechange', paint);
  }
}
