// Tests of the packages in a browser: `npm test`, with words of the names of those to run.
import { mkdir, writeFile } from 'node:fs/promises';

import { BEHAVIOUR } from './behaviour.mjs';
import { browser } from './browser.mjs';
import { NUMBERS } from './numbers.mjs';
import { PICTURES } from './pictures.mjs';
import { READMES } from './readmes.mjs';
import { serve } from './server.mjs';
import { closeStore, STREAMS } from './streams.mjs';

const OUT = new URL('./out/', import.meta.url);

const started = await browser();
if (started === undefined) {
  console.log('skipped: pages, no Chromium (set CHROMIUM to its program)');
  process.exit(0);
}
const server = await serve();
/** The page of the last test. */
let last;
const counts = { passed: 0, failed: 0 };
try {
  await mkdir(OUT, { recursive: true });
  const words = process.argv.slice(2);
  // Those that share a page together.
  const all = [...NUMBERS, ...BEHAVIOUR, ...READMES, ...STREAMS, ...PICTURES].toSorted(byShare);
  for (const test of all.filter(({ name }) => words.every((word) => name.includes(word)))) {
    const faults = await run(test).catch((error) => [String(error)]);
    counts[faults.length === 0 ? 'passed' : 'failed'] += 1;
    console.log(faults.length === 0 ? `ok      ${test.name}` : `FAILED  ${test.name}: ${faults.join('; ')}`);
  }
} finally {
  await started.close();
  await closeStore();
  server.close();
}
console.log(`${counts.passed} passed, ${counts.failed} failed`);
process.exitCode = counts.failed === 0 && counts.passed > 0 ? 0 : 1;

/** Orders tests by the page that they share, and leaves others where they are. */
function byShare(a, b) {
  return (a.share ?? '').localeCompare(b.share ?? '');
}

/** Opens a page that is ready for tests; `errors` collects what goes wrong in it. */
async function openPage() {
  const page = await started.newPage();
  const errors = [];
  page.on('pageerror', (error) => errors.push(`page: ${error.message}`));
  page.on('console', (message) => {
    if (message.type() === 'error') {
      errors.push(`console: ${message.text()}`);
    }
  });
  await page.goto(`${server.address}/test/page.html`);
  await page.waitForFunction(() => window.tests !== undefined, undefined, { timeout: 30_000 });
  return { page, errors };
}

/**
 * Runs a test in a page of its own, or in the last if it shares it; returns what is wrong. What a test opens for its page
 * adds arguments to the call, and may forgive errors.
 */
async function run({ name, share, open, call, check }) {
  if (share === undefined || share !== last?.share) {
    await last?.page.close();
    last = undefined;
    last = { share, ...(await openPage()) };
  }
  const { page, errors } = last;
  const [method, args] = call;
  try {
    const opened = await open?.(page);
    const all = [...args, ...(opened?.args ?? [])];
    const result = await page.evaluate(([method, args]) => window.tests[method](...args), [method, all]);
    opened?.forgive?.(errors);
    return [...errors.splice(0), ...(await check(result, (part, png) => save(`${name} ${part}`, png)))];
  } catch (error) {
    return [...errors.splice(0), String(error)];
  }
}

function save(name, png) {
  return writeFile(new URL(`${name.replaceAll(/[^a-z0-9]+/gi, '-')}.png`, OUT), Buffer.from(png, 'base64'));
}
