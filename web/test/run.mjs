// Tests of the packages in a browser: `npm test`, with words of the names of those to run.
import { mkdir, writeFile } from 'node:fs/promises';

import { BEHAVIOUR } from './behaviour.mjs';
import { browser } from './browser.mjs';
import { NUMBERS } from './numbers.mjs';
import { PICTURES } from './pictures.mjs';
import { READMES } from './readmes.mjs';
import { serve } from './server.mjs';

const OUT = new URL('./out/', import.meta.url);

const started = await browser();
if (started === undefined) {
  console.log('skipped: pages, no Chromium (set CHROMIUM to its program)');
  process.exit(0);
}
const server = await serve();
const counts = { passed: 0, failed: 0 };
try {
  await mkdir(OUT, { recursive: true });
  const words = process.argv.slice(2);
  const all = [...NUMBERS, ...BEHAVIOUR, ...READMES, ...PICTURES];
  for (const test of all.filter(({ name }) => words.every((word) => name.includes(word)))) {
    const faults = await run(test).catch((error) => [String(error)]);
    counts[faults.length === 0 ? 'passed' : 'failed'] += 1;
    console.log(faults.length === 0 ? `ok      ${test.name}` : `FAILED  ${test.name}: ${faults.join('; ')}`);
  }
} finally {
  await started.close();
  server.close();
}
console.log(`${counts.passed} passed, ${counts.failed} failed`);
process.exitCode = counts.failed === 0 && counts.passed > 0 ? 0 : 1;

/** Runs a test in a page of its own; returns what is wrong. */
async function run({ name, call, check }) {
  const page = await started.newPage();
  const errors = [];
  page.on('pageerror', (error) => errors.push(`page: ${error.message}`));
  page.on('console', (message) => {
    if (message.type() === 'error') {
      errors.push(`console: ${message.text()}`);
    }
  });
  try {
    await page.goto(`${server.address}/test/page.html`);
    await page.waitForFunction(() => window.tests !== undefined, undefined, { timeout: 30_000 });
    const result = await page.evaluate(([method, args]) => window.tests[method](...args), call);
    return [...errors, ...(await check(result, (part, png) => save(`${name} ${part}`, png)))];
  } catch (error) {
    return [...errors, String(error)];
  } finally {
    await page.close();
  }
}

function save(name, png) {
  return writeFile(new URL(`${name.replaceAll(/[^a-z0-9]+/gi, '-')}.png`, OUT), Buffer.from(png, 'base64'));
}
