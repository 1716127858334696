// Plays graded content of a character in node, by the module for web pages, and prints the result as JSON:
//   node device.mjs MODULES FILE.glb APPLICATION GRADE,... SECONDS
// MODULES is web/packages/core/wasm, which `cargo xtask web` makes.

import { readFile } from 'node:fs/promises';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [folder, file, application, grades, seconds] = process.argv.slice(2);
const { default: init, Publisher } = await import(pathToFileURL(resolve(folder, 'publish.js')));
await init({ module_or_path: await readFile(resolve(folder, 'publish_bg.wasm')) });
const options = { application, grades: grades.split(',').map(Number), seconds: Number(seconds) };
const bytes = new Uint8Array(await readFile(file));
process.stdout.write(Publisher.benchmark(bytes, file, JSON.stringify(options)));
