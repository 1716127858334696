// Installs the packed packages into a new Vite page that is the README's example, builds it and looks at it: `node
// test/packed.mjs`, after `cargo xtask web`, `npm ci` and `npm run build`. Needs a registry of npm.
import { execFileSync } from 'node:child_process';
import { copyFile, mkdtemp, mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

import { browser } from './browser.mjs';

const WEB = fileURLToPath(new URL('..', import.meta.url));
const CHARACTER = join(WEB, '../assets/glb/Quaternius_modular_women__Casual.glb');
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm' };

const started = await browser();
if (started === undefined) {
  console.log('skipped: the packed packages, no Chromium (set CHROMIUM to its program)');
  process.exit(0);
}
const folder = await mkdtemp(join(tmpdir(), 'packed-'));
try {
  await makePage();
  const { share, errors } = await look();
  const isRight = errors.length === 0 && share > 3;
  console.log(`${isRight ? 'ok     ' : 'FAILED '} figures cover ${share.toFixed(1)} % of the page ${errors.join('; ')}`);
  process.exitCode = isRight ? 0 : 1;
} finally {
  await started.close();
  await rm(folder, { recursive: true, force: true });
}

/** A page as a reader of the README makes it. */
async function makePage() {
  const npm = (words, cwd = folder) => execFileSync('npm', words, { cwd, stdio: ['ignore', 'pipe', 'inherit'], encoding: 'utf8' });
  const packed = JSON.parse(npm(['pack', '--json', '--pack-destination', folder, '--workspaces'], WEB));
  const files = Object.values(packed).map(({ filename }) => join(folder, filename));
  const readme = await readFile(join(WEB, 'packages/three/README.md'), 'utf8');
  const example = /```js\n([\s\S]*?)```/.exec(readme)[1];
  await writeFile(join(folder, 'package.json'), JSON.stringify({ name: 'page', private: true, type: 'module' }));
  await writeFile(join(folder, 'vite.config.js'), "export default { optimizeDeps: { exclude: ['@articula/core'] } };\n");
  await writeFile(join(folder, 'index.html'), '<!doctype html><title>Page</title><script type="module" src="/main.js"></script>\n');
  await writeFile(join(folder, 'main.js'), `${example}\nwindow.example = { renderer, scene, camera };\n`);
  await mkdir(join(folder, 'public'));
  await copyFile(CHARACTER, join(folder, 'public/character.glb'));
  npm(['install', '--silent', '--no-audit', '--no-fund', ...files, 'three', 'vite']);
  npm(['exec', 'vite', 'build', '--', '--target', 'esnext', '--logLevel', 'warn']);
}

/** Opens what was built; returns the percentage of pixels that show something, and what went wrong. */
async function look() {
  const server = createServer((request, response) => {
    const path = normalize(new URL(request.url, 'http://host').pathname);
    const file = join(folder, 'dist', path === '/' ? 'index.html' : path);
    if (!existsSync(file)) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const page = await started.newPage({ viewport: { width: 640, height: 360 } });
  const errors = [];
  page.on('pageerror', (error) => errors.push(error.message));
  try {
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await page.waitForFunction(() => window.example !== undefined, undefined, { timeout: 300_000 });
    const share = await page.evaluate(() => {
      const { renderer, scene, camera } = window.example;
      renderer.render(scene, camera);
      const canvas = new OffscreenCanvas(640, 360);
      const context = canvas.getContext('2d');
      context.drawImage(renderer.domElement, 0, 0, 640, 360);
      const { data } = context.getImageData(0, 0, 640, 360);
      const shown = data.filter((level, i) => i % 4 !== 3 && level > 16);
      return (100 * shown.length) / (3 * 640 * 360);
    });
    await page.screenshot({ path: join(WEB, 'test/out/packed.png') });
    return { share, errors };
  } finally {
    server.closeAllConnections();
    server.close();
  }
}
