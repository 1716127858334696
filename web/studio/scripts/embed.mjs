// Puts the built pages where the program with the feature `studio` embeds them: each file compressed, as it is sent.
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const [FROM, TO] = ['../dist', '../embedded'].map((path) => fileURLToPath(new URL(path, import.meta.url)));

rmSync(TO, { recursive: true, force: true });
let total = 0;
for (const entry of readdirSync(FROM, { recursive: true, withFileTypes: true })) {
  if (entry.isFile()) {
    const path = join(entry.parentPath, entry.name);
    const to = join(TO, path.slice(FROM.length));
    const bytes = gzipSync(readFileSync(path), { level: 9 });
    mkdirSync(dirname(to), { recursive: true });
    writeFileSync(`${to}.gz`, bytes);
    total += bytes.length;
  }
}
console.log(`studio: ${(total / 1e6).toFixed(1)} MB of pages to embed`);
