// Tests of the studio in a browser: `npm test`, with words of the names of those to run.
import { mkdirSync } from 'node:fs';

import { browser } from '../../test/browser.mjs';
import { serve } from '../../test/server.mjs';
import { CAMERA } from './camera.mjs';
import { CONTROLS } from './controls.mjs';
import { DEVICES } from './devices.mjs';
import { DROPS } from './drops.mjs';
import { ENCODER } from './encoder.mjs';
import { FAULTS } from './faults.mjs';
import { closeFirefox, FIREFOX } from './firefox.mjs';
import { FLAT } from './flat.mjs';
import { LIGHTER } from './lighter.mjs';
import { LOOKS } from './looks.mjs';
import { native } from './native.mjs';
import { OFFLINE } from './offline.mjs';
import { RECORDING } from './recording.mjs';
import { STEERING } from './steering.mjs';
import { closeStore, STREAMS } from './streams.mjs';

const started = await browser();
if (started === undefined) {
  console.log('skipped: studio, no Chromium (set CHROMIUM to its program)');
  process.exit(0);
}
mkdirSync(new URL('./out/', import.meta.url), { recursive: true });
const server = await serve();
/** Programs are run for the tests that need them alone. */
let programs;
const counts = { passed: 0, failed: 0 };
/** What was not there, told once. */
const missing = new Set();
try {
  const words = process.argv.slice(2);
  for (const { name, needs, run } of [...STEERING, ...CONTROLS, ...CAMERA, ...RECORDING, ...OFFLINE, ...DROPS, ...FAULTS, ...FLAT, ...LIGHTER, ...DEVICES, ...ENCODER, ...LOOKS, ...STREAMS, ...FIREFOX].filter((test) => words.every((word) => test.name.includes(word)))) {
    const start = performance.now();
    if (needs === 'native') {
      programs ??= native();
      if (programs === undefined) {
        console.log(`skipped: ${name} (articula and articula-library-hash are not built)`);
        continue;
      }
    }
    const faults = await run({ browser: started, server, programs }).catch((error) => [error.stack]);
    if (faults.skipped !== undefined) {
      if (!missing.has(faults.skipped)) {
        console.log(`skipped: ${faults.skipped}`);
      }
      missing.add(faults.skipped);
      continue;
    }
    counts[faults.length === 0 ? 'passed' : 'failed'] += 1;
    const secs = ((performance.now() - start) / 1000).toFixed(1);
    console.log(faults.length === 0 ? `ok      ${name} (${secs} s)` : `FAILED  ${name}: ${faults.join('; ')}`);
  }
} finally {
  await started.close();
  await closeFirefox();
  server.close();
  programs?.end();
  await closeStore();
}
console.log(`${counts.passed} passed, ${counts.failed} failed`);
process.exitCode = counts.failed === 0 && counts.passed > 0 ? 0 : 1;
