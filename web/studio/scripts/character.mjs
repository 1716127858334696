// Makes the character that the page begins with: the mannequin of the library, prepared, whose scores can be compared. It is made again when
// the program is newer than the file.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = fileURLToPath(new URL('../../../', import.meta.url));
const OUT = fileURLToPath(new URL('../public/human.glb', import.meta.url));

const given = process.env.ARTICULA;
const programs = given === undefined ? ['release', 'debug'].map((kind) => join(ROOT, 'target', kind, 'articula')) : [given];
const program = programs.find((path) => existsSync(path));
if (program === undefined) {
  if (!existsSync(OUT)) {
    console.error(`studio: no program at ${programs.join(' or ')}; run cargo build --release -p articula-cli, or name it in ARTICULA`);
    process.exit(1);
  }
} else if (!existsSync(OUT) || statSync(OUT).mtimeMs < statSync(program).mtimeMs) {
  const folder = mkdtempSync(join(tmpdir(), 'articula-studio-'));
  try {
    const human = join(folder, 'human.glb');
    mkdirSync(fileURLToPath(new URL('../public', import.meta.url)), { recursive: true });
    execFileSync(program, ['human', '--quiet', '--mannequin', '--triangles', '12000', human], { stdio: ['ignore', 'ignore', 'inherit'] });
    execFileSync(program, ['build', '--quiet', '--force', '--levels', '4', human, OUT], { stdio: ['ignore', 'ignore', 'inherit'] });
  } finally {
    rmSync(folder, { recursive: true });
  }
}
