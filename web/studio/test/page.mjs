// The studio in a browser: a page of its own for a test, what it asked the network for, and what went wrong in it.
import { readFileSync } from 'node:fs';

/** Opens the studio at a fragment, waits until it shows frames, and stops its clock. `before` runs in it at first. */
export async function openStudio(browser, address, { hash = '', width = 640, height = 560, path = '/studio/dist/index.html', before } = {}) {
  const context = await browser.newContext({ viewport: { width, height } });
  context.setDefaultTimeout(10_000);
  const page = await context.newPage();
  if (before !== undefined) {
    await page.addInitScript(before);
  }
  const errors = [];
  const requests = [];
  page.on('pageerror', (error) => errors.push(`page: ${error.message}`));
  page.on('console', (message) => {
    if (message.type() === 'error') {
      errors.push(`console: ${message.text()}`);
    }
  });
  page.on('request', (request) => requests.push(request.url()));
  page.on('requestfailed', (request) => {
    // What a page that is left was fetching is not missing.
    if (request.failure()?.errorText !== 'net::ERR_ABORTED') {
      errors.push(`request: ${request.url()}`);
    }
  });
  await page.goto(`${address}${path}${hash}`);
  await page.waitForFunction(() => globalThis.articulaStudio?.frames > 3, undefined, { timeout: 40_000 });
  await page.evaluate(() => globalThis.articulaStudio.viewport.run(false));
  return { context, page, errors, requests };
}

/** Goes on by frames of a step of the page's clock, at once and without drawing. */
export function step(page, frames, secs) {
  return page.evaluate(([count, dt]) => {
    for (let i = 0; i < count; i += 1) {
      globalThis.articulaStudio.viewport.advance(dt);
    }
  }, [frames, secs]);
}

/** States and counts of the first column, and the colours of its joints. */
export function column(page) {
  return page.evaluate(() => {
    const [first] = globalThis.articulaStudio.current.columns;
    const colors = [];
    first.root.traverse((object) => {
      if (object.isInstancedMesh && colors.length === 0) {
        colors.push(...object.instanceColor.array);
      }
    });
    return { states: [...first.figure.core.jointStates], figures: first.figures(), colors };
  });
}

/** Joints that an expression chooses, by the library. */
export function jointsOf(page, expression) {
  return page.evaluate((text) => [...globalThis.articulaStudio.studio.character.asset.core.jointsOfExpression(text)], expression);
}

/** Draws a frame. */
export function draw(page) {
  return page.evaluate(() => globalThis.articulaStudio.viewport.step(0));
}

/** Moves a slider to a value, as dragging it does. */
export async function slide(page, label, value) {
  await page.getByLabel(label, { exact: true }).evaluate((input, to) => {
    input.value = String(to);
    input.dispatchEvent(new Event('input', { bubbles: true }));
  }, value);
}

/** Opens a file by the picker and resolves when its character is shown. */
export async function openFile(page, name, bytes) {
  const shown = page.evaluate(() => new Promise((resolve) => {
    globalThis.articulaStudio.studio.addEventListener('character', () => resolve(globalThis.articulaStudio.studio.character.name), { once: true });
  }));
  await page.locator('.top input[type=file]').setInputFiles({ name, mimeType: 'application/octet-stream', buffer: Buffer.from(bytes) });
  return shown;
}

/** Faults that axe finds, one line each. */
export async function axe(page) {
  const source = readFileSync(new URL(import.meta.resolve('axe-core')), 'utf8');
  await page.evaluate(source);
  const found = await page.evaluate(() => globalThis.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] }));
  return found.violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html.slice(0, 90)).slice(0, 3).join(' | ')}`);
}
