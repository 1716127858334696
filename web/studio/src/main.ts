import './styles/base.css';
import './styles/controls.css';
import './styles/pages.css';

import { CrowdPage } from './crowd/crowd.js';
import { DevicesPage } from './devices/devices.js';
import { ACCEPTED } from './files.js';
import { FlatPage } from './flat/flat.js';
import { LighterPage } from './lighter/lighter.js';
import { StagePage } from './stage/stage.js';
import { readState, type StudioState } from './state.js';
import { StreamPage } from './stream/stream.js';
import { Studio } from './studio.js';
import { h } from './ui/dom.js';
import { Notices, TaskLine } from './ui/status.js';
import { themeButton } from './ui/theme.js';
import { Viewport } from './view/viewport.js';

/** A page of the studio. */
interface Page {
  readonly main: HTMLElement;
  readonly panel: HTMLElement;
  mount(): void;
  unmount(): void;
}

/** Milliseconds from the first picture to fetching the tools. */
const KEEP_AFTER_MS = 1500;

const PAGES: readonly (readonly [StudioState['page'], string])[] = [
  ['stage', 'Stage'],
  ['crowd', 'Crowd'],
  ['flat', 'Flat'],
  ['lighter', 'Lighter'],
  ['stream', 'Stream'],
  ['devices', 'Devices'],
];

const app = document.querySelector('#app') as HTMLElement;
const notices = new Notices();
const task = new TaskLine();
const mainView = h('main', { id: 'main', tabindex: -1 }, h('div', { class: 'loading', role: 'status' }, 'Loading the module and a character…'));
const sidePanel = h('aside', { class: 'panel', 'aria-label': 'Controls' });
const tabs = new Map<string, HTMLAnchorElement>();
const fileName = h('span', { class: 'file-name' });

const picker = h('input', { type: 'file', accept: ACCEPTED, hidden: true, 'aria-label': 'Character or motion' });
const openButton = h('button', { type: 'button', class: 'button', disabled: true, onclick: () => picker.click() }, 'Open a file');
const nav = h('nav', { 'aria-label': 'Pages' }, ...PAGES.map(([page, title]) => {
  const tab = h('a', { href: `#${page}`, class: 'tab' }, title);
  tabs.set(page, tab);
  return tab;
}));
const header = h('header', { class: 'top' },
  h('a', { class: 'skip', href: '#main', onclick: (event: Event) => {
    event.preventDefault();
    mainView.focus();
  } }, 'To the picture'),
  h('h1', {}, 'Articula', h('span', {}, ' studio')),
  nav,
  h('div', { class: 'top-end' }, fileName, openButton, picker, themeButton()));
const footer = h('footer', { class: 'foot' }, h('p', {}, 'Files stay on this machine: the page reads them here and sends nothing. '), h('p', {}, 'Drop GLB, VRM or FBX for a character, BVH, FAP or CSV for a motion, WAV for a voice, JSON for a level.'));
app.append(header, h('div', { class: 'work' }, mainView, sidePanel), footer, notices.element);

void begin();

async function begin(): Promise<void> {
  if (document.createElement('canvas').getContext('webgl2') === null) {
    fail('This browser has no WebGL 2', 'The studio draws with it. Turn on hardware acceleration, or open the page in another browser.');
    return;
  }
  try {
    const viewport = new Viewport();
    show(await Studio.start(task, notices), viewport);
  } catch (error) {
    fail('The studio could not start', error instanceof Error ? error.message : String(error));
  }
}

function fail(title: string, text: string): void {
  mainView.replaceChildren(h('div', { class: 'empty', role: 'alert' }, h('strong', {}, title), h('p', {}, text)));
}

function show(studio: Studio, viewport: Viewport): void {
  const makers: Record<StudioState['page'], () => Page> = {
    stage: () => new StagePage(studio, viewport),
    crowd: () => new CrowdPage(studio, viewport),
    flat: () => new FlatPage(studio, viewport),
    lighter: () => new LighterPage(studio, viewport),
    stream: () => new StreamPage(studio, viewport),
    devices: () => new DevicesPage(studio, viewport),
  };
  const made = new Map<string, Page>();
  let current: Page | undefined;
  const go = (page: StudioState['page']): void => {
    current?.unmount();
    current = made.get(page) ?? makers[page]();
    made.set(page, current);
    for (const [name, tab] of tabs) {
      tab.setAttribute('aria-current', name === page ? 'page' : 'false');
    }
    document.title = `${PAGES.find(([name]) => name === page)?.[1] ?? ''} – Articula studio`;
    mainView.replaceChildren(current.main);
    sidePanel.replaceChildren(task.element, current.panel);
    hook.current = current;
    current.mount();
  };
  const say = (): void => {
    fileName.textContent = studio.character.name;
    fileName.title = studio.character.asset.warnings.join('\n');
  };
  /** What tests and the console of a developer read: the page that is shown, and frames one by one. */
  const hook = { studio, viewport, current, get frames() {
    return viewport.frames;
  } };
  Object.assign(globalThis, { articulaStudio: hook });
  for (const [page, tab] of tabs) {
    tab.addEventListener('click', (event) => {
      event.preventDefault();
      studio.set({ page: page as StudioState['page'] });
      go(page as StudioState['page']);
    });
  }
  addEventListener('hashchange', () => {
    // The visitor came by another link: all is made anew from it.
    studio.state = readState(location.hash);
    current?.unmount();
    made.clear();
    go(studio.state.page);
  });
  studio.addEventListener('character', say);
  // A file may belong to another page than the one that it was dropped on.
  studio.addEventListener('page', () => {
    if (current !== made.get(studio.state.page)) {
      go(studio.state.page);
    }
  });
  openButton.disabled = false;
  picker.addEventListener('change', () => {
    const file = picker.files?.[0];
    if (file !== undefined) {
      void studio.open(file);
    }
    picker.value = '';
  });
  takeDrops(studio);
  say();
  go(studio.state.page);
  keepTools(studio);
}

/** Fetches the tools when the page has nothing else to do, unless the visitor saves data. */
function keepTools(studio: Studio): void {
  const { connection } = navigator as Navigator & { connection?: { saveData?: boolean } };
  if (connection?.saveData !== true) {
    setTimeout(() => void studio.tools.keep(), KEEP_AFTER_MS);
  }
}

/** Opens what is dropped anywhere on the page. */
function takeDrops(studio: Studio): void {
  const veil = h('div', { class: 'drop-veil', hidden: true }, h('p', {}, 'Drop to open. The file stays on this machine.'));
  app.append(veil);
  let depth = 0;
  const end = (): void => {
    depth = 0;
    veil.hidden = true;
  };
  addEventListener('dragenter', (event) => {
    event.preventDefault();
    depth += 1;
    veil.hidden = false;
  });
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('dragleave', () => {
    depth -= 1;
    if (depth <= 0) {
      end();
    }
  });
  addEventListener('drop', (event) => {
    event.preventDefault();
    end();
    const given = event.dataTransfer?.items[0]?.webkitGetAsEntry?.();
    if (given?.isDirectory) {
      studio.notices.fault(`${given.name} is a folder: drop the files in it one by one. The folder of a digital item is shown by a server: articula serve FOLDER.`);
      return;
    }
    const file = event.dataTransfer?.files[0];
    if (file !== undefined) {
      void studio.open(file);
    }
  });
}
