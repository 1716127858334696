// Makes the characters of the page: the reference human, prepared, with which it begins, and the mannequin, whose scores of the benchmark can
// be compared. They are made again when the program is newer than the files.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = fileURLToPath(new URL('../../../', import.meta.url));
const [PUBLIC, HUMAN, MANNEQUIN] = ['', 'human.glb', 'mannequin.glb'].map((name) => fileURLToPath(new URL(`../public/${name}`, import.meta.url)));

const given = process.env.ARTICULA;
const programs = given === undefined ? ['release', 'debug'].map((kind) => join(ROOT, 'target', kind, 'articula')) : [given];
const timeOf = (path) => statSync(path).mtimeMs;
// The newest: a release program may be of before.
const program = programs.filter((path) => existsSync(path)).sort((a, b) => timeOf(b) - timeOf(a))[0];
const isHere = [HUMAN, MANNEQUIN].every((path) => existsSync(path));
const quiet = { stdio: ['ignore', 'ignore', 'inherit'] };
if (program === undefined) {
  if (!isHere) {
    console.error(`studio: no program at ${programs.join(' or ')}; run cargo build --release -p articula-cli, or name it in ARTICULA`);
    process.exit(1);
  }
} else if (!isHere || timeOf(HUMAN) < timeOf(program)) {
  const folder = mkdtempSync(join(tmpdir(), 'articula-studio-'));
  try {
    const human = join(folder, 'human.glb');
    mkdirSync(PUBLIC, { recursive: true });
    execFileSync(program, ['human', '--quiet', '--force', '--mannequin', '--triangles', '12000', MANNEQUIN], quiet);
    execFileSync(program, ['human', '--quiet', '--triangles', '6000', human], quiet);
    execFileSync(program, ['build', '--quiet', '--force', '--levels', '4', human, HUMAN], quiet);
  } finally {
    rmSync(folder, { recursive: true });
  }
}
