import { choice, section, segmented, slider, toggle } from '../ui/controls.js';
import { h } from '../ui/dom.js';
import type { StudioState } from '../state.js';
import type { Studio } from '../studio.js';
import { packCameras } from './view-of.js';
import { type Viewport, WIDTH_TO_HEIGHT } from '../view/viewport.js';
import { CameraPanel } from './camera.js';
import { ClipsPanel } from './clips.js';
import { colors, paintLegend } from './colors.js';
import { type ColumnRule, StageColumn, widthOf } from './column.js';
import { EvaluatePanel } from './evaluate.js';
import { FacePanel } from './face.js';
import { chosenJoints, LEVELS, LevelsPanel, spoken } from './levels.js';
import { LivePanel } from './live.js';
import { MetricPanel } from './metric.js';
import { dragged, placement } from './placement.js';
import { RecordingPanel } from './recording.js';
import { takeHome } from './take-home.js';
import { Timeline } from './timeline.js';
import { VoiceSound } from './voice.js';
import { Weights } from './weights.js';

/** Fields of the state whose change makes the metric and its transitions anew. */
const STEERED = ['metric', 'pixels', 'threshold', 'farthest', 'curve', 'lookup', 'transition', 'ease', 'passive'] as const;

/** Where the camera begins, radians from the front. */
const YAW = 0.45;

/** One character in one view or several, and all that decides which of its joints move. */
export class StagePage {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  columns: StageColumn[] = [];
  readonly timeline: Timeline;
  readonly voice: VoiceSound;
  readonly #studio: Studio;
  readonly #viewport: Viewport;
  readonly #levels: LevelsPanel;
  readonly #metric: MetricPanel;
  readonly #clips: ClipsPanel;
  readonly #face: FacePanel;
  readonly #camera: CameraPanel;
  readonly #recording: RecordingPanel;
  readonly #live = new LivePanel();
  readonly #weights: Weights;
  readonly #labels = h('div', { class: 'column-labels' });
  readonly #counts = { active: h('b', {}), passive: h('b', {}), changing: h('b', {}) };
  #before: StudioState;
  #joints: Uint32Array = new Uint32Array();
  /** Error of the first column in pixels: of 95 % of the skin, and the worst. */
  error: readonly [number, number] = [0, 0];

  constructor(studio: Studio, viewport: Viewport) {
    this.#studio = studio;
    this.#viewport = viewport;
    this.#before = { ...studio.state };
    this.voice = new VoiceSound(studio.notices);
    this.timeline = new Timeline(studio, this.voice.element);
    this.#weights = new Weights(studio);
    this.#levels = new LevelsPanel(studio);
    this.#metric = new MetricPanel(studio);
    this.#clips = new ClipsPanel(studio);
    this.#face = new FacePanel(studio, () => this.columns);
    this.#camera = new CameraPanel(studio, viewport, this.timeline, () => this.columns[0]);
    this.#recording = new RecordingPanel(studio, viewport, () => this.columns[0]);
    const evaluate = new EvaluatePanel(studio, () => this.#expression());
    const key = (kind: string, word: string, count: HTMLElement): HTMLElement => h('li', { class: kind }, word, ' ', count);
    const legend = h('ul', { class: 'state-key', 'aria-label': 'Joints by state' }, key('active', 'active', this.#counts.active), key('passive', 'passive', this.#counts.passive), key('changing', 'in transition', this.#counts.changing));
    this.main = h('div', { class: 'stage' }, h('div', { class: 'picture-frame' }, this.#labels, legend), this.timeline.element);
    this.panel = h('div', { class: 'panel-body' }, this.#live.element, this.#levels.element, this.#metric.element, this.#clips.element, this.#view(), placement(studio), this.#camera.element, this.#face.element, this.#recording.element, evaluate.element, takeHome(studio, viewport, () => this.#expression()));
    studio.addEventListener('state', () => this.#follow());
    studio.addEventListener('character', () => this.#renew());
    studio.addEventListener('selection', () => this.#levels.renew());
    dragged(studio, viewport, this.main);
  }

  mount(): void {
    this.#viewport.showIn(this.main, (dt) => this.#frame(dt));
    this.#viewport.controls.enabled = !this.#studio.state.drag;
    this.#renew();
  }

  unmount(): void {
    this.#camera.end();
    this.#recording.end();
    this.voice.end();
    this.#viewport.controls.enabled = true;
    this.columns[0]?.dress({ ...this.#studio.state, body: 'solid' });
    this.#clear();
  }

  /** Weight of the errors by which thresholds decide now. */
  get weight(): number {
    return this.#weights.beta;
  }

  /** Draws a time of the clip and leaves it there. */
  seek(secs: number): void {
    this.timeline.pause();
    this.timeline.seek(secs);
    this.#viewport.advance(0);
  }

  #view(): HTMLElement {
    const { state } = this.#studio;
    const set = (change: Partial<StudioState>): void => this.#studio.set(change);
    const columns = segmented('Side by side', [['one', 'One view'], ['two', 'Compare'], ['levels', 'All levels']], state.columns, (word) => set({ columns: word as StudioState['columns'] }));
    const body = choice('Body', [['clear', 'See-through'], ['solid', 'Solid'], ['none', 'Hidden']], state.body, (word) => set({ body: word as StudioState['body'] }));
    const skeleton = toggle('Skeleton', state.skeleton, (on) => set({ skeleton: on }));
    const radius = slider({ label: 'Size of joints', min: 0.3, max: 3, step: 0.1, value: state.radius, shown: (n) => `${Math.round(100 * n)} %`, onInput: (n) => set({ radius: n }) });
    return section('View', true, columns.element, body.element, skeleton.element, radius.element, colors(this.#studio));
  }

  /** What the columns show. */
  #rules(): ColumnRule[] {
    const { core, joints } = this.#studio.character.asset;
    const all = Uint32Array.from(joints, (_, joint) => joint);
    const chosen: ColumnRule = { title: 'Chosen joints', joints: this.#joints, measured: true };
    switch (this.#studio.state.columns) {
      case 'one':
        return [chosen];
      case 'two':
        return [chosen, { title: 'All joints', joints: all, measured: false }];
      case 'levels':
        return LEVELS.map((level) => ({ title: spoken(level), joints: core.jointsOfExpression(`loa(${level})`), measured: true }));
    }
  }

  /** Makes all anew for another character. */
  #renew(): void {
    if (!this.#viewport.element.isConnected || !this.#viewport.isIn(this.main)) {
      return;
    }
    this.#camera.end();
    this.#recording.end();
    this.#clear();
    paintLegend(this.main, this.#studio.state);
    this.#select();
    this.#levels.renew();
    this.#metric.renew();
    this.#clips.renew();
    this.#face.renew();
    this.#makeColumns();
    if (!this.#viewport.place(this.#studio.state.camera)) {
      this.#fit();
    }
    this.#viewport.step(0);
  }

  #fit(): void {
    this.#viewport.fit(this.#studio.character.asset.bounds, YAW, undefined, WIDTH_TO_HEIGHT + widthOf(this.#studio.state.clones));
  }

  #makeColumns(): void {
    const { state, character } = this.#studio;
    this.columns = this.#rules().map((rule) => new StageColumn(character.asset, rule, state.clones));
    for (const column of this.columns) {
      column.steer(state);
      column.stand(state);
      this.#viewport.scene.add(column.root);
    }
    this.columns[0]?.dress(state);
    this.columns.forEach((column) => column.dress(state));
    this.#viewport.columns = this.columns;
    this.#labels.replaceChildren(...(this.columns.length < 2 ? [] : this.columns.map(({ title }) => h('div', {}, h('span', {}, title), h('small', {})))));
    this.#labels.hidden = this.columns.length < 2;
    this.main.classList.toggle('many', this.columns.length > 1);
    this.#face.apply();
    this.#play();
    this.#weigh();
  }

  #clear(): void {
    this.columns.forEach((column) => column.dispose());
    this.columns = [];
    this.#viewport.columns = [];
  }

  #play(): void {
    const { asset } = this.#studio.character;
    const clip = Math.max(asset.clips.indexOf(this.#studio.state.clip), 0);
    this.timeline.setLength(asset.clipSecs[clip] ?? 1);
    this.voice.load(this.#studio.voices.get(asset.clips[clip] ?? ''));
    if (asset.clips.length > 0) {
      const travels = this.#studio.cameras.has(asset.clips[clip] ?? '');
      this.columns.forEach((column) => column.play(clip, this.timeline.secs, travels));
    }
  }

  /** Takes over what the selectors choose; a mistake leaves what was chosen before. */
  #select(): void {
    try {
      this.#joints = chosenJoints(this.#studio);
      this.#levels.say(this.#joints.length);
    } catch (error) {
      this.#levels.say(error instanceof Error ? error : new Error(String(error)));
      if (this.#joints.length === 0) {
        this.#joints = Uint32Array.from(this.#studio.character.asset.joints, (_, joint) => joint);
      }
    }
  }

  /** Takes over a change of the state. */
  #follow(): void {
    const { state } = this.#studio;
    const before = this.#before;
    this.#before = { ...state };
    if (this.columns.length === 0) {
      return;
    }
    const differs = (...keys: readonly (keyof StudioState)[]): boolean => keys.some((key) => state[key] !== before[key]);
    if (differs('complexity', 'depth', 'hanim', 'zones', 'rule', 'plus', 'minus', 'expression')) {
      this.#select();
      if (state.columns !== 'levels') {
        this.columns[0]?.articulate(this.#joints);
      }
    }
    if (differs('columns', 'clones')) {
      this.#clear();
      this.#makeColumns();
    }
    if (differs('columns')) {
      state.camera = '';
      this.#fit();
    } else if (differs('clones') && this.#viewport.isFitted) {
      this.#fit();
    }
    if (differs(...STEERED)) {
      this.#steer();
    }
    if (differs('clip')) {
      this.timeline.secs = 0;
      this.#play();
    }
    if (differs('beta', 'metric', 'clip')) {
      this.#weigh();
    }
    if (differs('body', 'skeleton', 'radius', 'activeColor', 'passiveColor', 'changingColor')) {
      paintLegend(this.main, state);
      this.columns.forEach((column) => column.dress(state));
    }
    this.columns.forEach((column) => column.stand(state));
  }

  #steer(): void {
    const rules = this.#rules();
    this.columns.forEach((column, i) => column.steer(this.#studio.state, rules[i]));
  }

  /** Takes over the weight of the metric's errors, as soon as they are found. */
  #weigh(): void {
    void this.#weights.apply(() => this.columns, () => this.#steer());
  }

  #frame(dtSecs: number): void {
    this.timeline.advance(dtSecs);
    this.#camera.frame(dtSecs);
    this.#face.frame(dtSecs);
    const { playing, speed } = this.#studio.state;
    this.voice.follow(this.timeline.secs, playing, speed);
    const start = performance.now();
    for (const column of this.columns) {
      column.update(this.timeline.now, this.timeline.secs, this.#viewport);
    }
    const ms = performance.now() - start;
    this.#recording.frame(dtSecs);
    const [first] = this.columns;
    if (first === undefined) {
      return;
    }
    const figures = first.figures();
    this.error = this.#errorOf(first);
    this.#counts.active.textContent = String(figures.active);
    this.#counts.passive.textContent = String(figures.passive);
    this.#counts.changing.textContent = String(figures.changing);
    this.#live.update(figures, this.columns.length > 1 ? first.title : undefined, this.#studio.character.asset.joints.length, this.error, ms);
    if (this.columns.length > 1 && this.#viewport.frames % 6 === 0) {
      this.#labels.style.gridTemplateColumns = `repeat(${this.#viewport.grid.across}, 1fr)`;
      this.columns.forEach((column, i) => {
        const said = this.#labels.children[i]?.lastElementChild;
        if (said) {
          said.textContent = `${column.figures().updated} joints · ${this.#errorOf(column)[0].toFixed(1)} px`;
        }
      });
    }
  }

  #errorOf(column: StageColumn): readonly [number, number] {
    const view = packCameras(this.#viewport, column.figure);
    const [p95 = 0, worst = 0] = column.figure.core.errorPx(view);
    return [p95, worst];
  }

  /** The joints chosen now, as an expression. */
  #expression(): string {
    const { expression } = this.#studio.state;
    const { joints } = this.#studio.character.asset;
    return expression !== '' ? expression : [...this.#joints].map((joint) => `joint(${joints[joint]})`).join(' + ') || 'loa(None)';
  }
}
