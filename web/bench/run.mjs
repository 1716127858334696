// Times crowds in a page, beside what else shows many characters in three.js: `node bench/run.mjs FILE…`, prepared
// GLB files. Prints a table; `--json` prints the numbers.
import { readFile } from 'node:fs/promises';
import { basename } from 'node:path';

import { browser } from '../test/browser.mjs';
import { serve } from '../test/server.mjs';

const COUNTS = [100, 1000, 5000];
const words = process.argv.slice(2);
const files = words.filter((word) => !word.startsWith('--'));
const started = await browser();
if (started === undefined) {
  console.error('no Chromium; set CHROMIUM to its program');
  process.exit(1);
}
const server = await serve();
const results = [];
try {
  for (const file of files) {
    results.push({ file: basename(file), ...(await measured(file)) });
  }
} finally {
  await started.close();
  server.close();
}
console.log(words.includes('--json') ? JSON.stringify(results, undefined, 1) : page(results));

async function measured(file) {
  const page = await started.newPage();
  page.on('pageerror', (error) => console.error(`page: ${error.message}`));
  await page.goto(`${server.address}/bench/page.html`);
  await page.waitForFunction(() => window.bench !== undefined, undefined, { timeout: 30_000 });
  const url = `/bench/file/${encodeURIComponent(basename(file))}`;
  // From the server: answering the request in its place would take longer than opening the file.
  await fetch(server.address + url, { method: 'PUT', body: await readFile(file) });
  const found = await page.evaluate(([at, counts]) => window.bench.file(at, counts), [url, COUNTS]);
  await page.close();
  return found;
}

function page(all) {
  return `# Crowds in web pages

Made by \`cargo xtask bench-web --write\` in Chromium without a display, one page for each file. Characters stand in a square, 1.5 m
apart, and play one clip from times of their own; the camera is at the middle of an edge and sees 1280 x 720 pixels. Times are
those of the main thread until all arrays for the GPU are filled, without drawing: \`AnimationMixer\`, world matrices and skeletons of
three.js, \`setTime\` and \`setBonesAt\` of @three.ez/instanced-mesh, two integers a character for a texture of poses at 30 Hz, the one
time of \`BakedVertexAnimationManager\` of Babylon.js for thin instances whose frames are counted from the start, at 30 Hz too, and
\`update\` of \`ArticulaCrowd\`, which culls and plans as well. They depend on the machine: compare within a page. Pixels off: of those that show
one of 64 figures at 640 x 360 by \`WebGLRenderer\`, the share that differs by more than 8 levels from three.js's own skinning; Babylon.js draws grey figures, and
is compared with exact poses in its own shaders. Bytes are those that a frame changes.

${all.map(table).join('\n')}`;
}

function table({ file, clip, joints, moduleMs, openMs, firstMs, rows, errors }) {
  const of = (count, name) => rows.find((row) => row.count === count && row.name === name);
  const cell = ({ median, least }) => `${short(median)} [${short(least)}]`;
  const names = [...new Set(rows.map(({ name }) => name))];
  const lines = names.map((name) => {
    const cells = COUNTS.map((count) => cell(of(count, name)));
    const bytes = of(1000, name).bytes / 1000;
    const error = errors[name.replace(/^Articula, /, '')];
    return `| ${[name, ...cells, bytes.toFixed(0), error?.percent.toFixed(2) ?? ''].join(' | ')} |`;
  });
  const ratio = (other) => (of(1000, other).median / of(1000, 'Articula, all joints').median).toFixed(1);
  return `## ${file}

Clip ${clip}, ${joints} joints. The module is loaded in ${moduleMs.toFixed(0)} ms, the file opened in ${openMs.toFixed(0)}; the first frame of a crowd of ten comes ${firstMs[0].toFixed(0)} ms
later, and ${firstMs[1].toFixed(0)} with cached poses.

| main thread, ms a frame: median [least] of 5 | 100 | 1,000 | 5,000 | bytes a character at 1,000 | pixels off, % |
| --- | --- | --- | --- | --- | --- |
${lines.join('\n')}

At 1,000 all joints take 1/${ratio('SkinnedMesh, a mixer each')} of mixers and 1/${ratio('instanced-mesh, one mixer')} of instanced-mesh.
`;
}

function short(ms) {
  return ms >= 100 ? ms.toFixed(0) : ms.toPrecision(3);
}
