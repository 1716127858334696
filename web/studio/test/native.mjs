// What the library does on this machine: a file that it prepares now, the palettes that its player shows, and programs.
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const ROOT = fileURLToPath(new URL('../../../', import.meta.url));
const built = (name) => ['debug', 'release'].map((kind) => join(ROOT, 'target', kind, name));
const found = (given, name) => (given === undefined ? built(name) : [given]).find((path) => existsSync(path));

/** Takes a character through the library, and returns the hashes of the steps; `cargo xtask test` has just done so. */
function taken(program, file) {
  const [steps, prepared] = ['library-steps.txt', 'prepared.glb'].map((name) => join(ROOT, 'target/xtask', name));
  const time = (path) => statSync(path, { throwIfNoEntry: false })?.mtimeMs ?? 0;
  if (Math.min(time(steps), time(prepared)) > time(program)) {
    copyFileSync(prepared, file);
    return readFileSync(steps, 'utf8');
  }
  return execFileSync(program, [file], { encoding: 'utf8' });
}

/** Starts the programs; undefined, with a line that says so, if one is not built. */
export function native() {
  const articula = found(process.env.ARTICULA, 'articula');
  const hashes = found(process.env.ARTICULA_LIBRARY_HASH, 'articula-library-hash');
  if (articula === undefined || hashes === undefined) {
    return undefined;
  }
  const folder = mkdtempSync(join(tmpdir(), 'articula-studio-'));
  const file = join(folder, 'knight.glb');
  const steps = taken(hashes, file);
  const run = (...words) => execFileSync(articula, words, { encoding: 'utf8' });
  return {
    bytes: readFileSync(file),
    /** Hash FNV-1a of the palettes of twelve frames of FigurePlayer. */
    palettes: steps.split('\n').find((line) => line.startsWith('palettes of the figure: '))?.slice(-16),
    rows: (...words) => JSON.parse(run('lod', file, '--json', ...words)).rows,
    /** What `articula lod` tells of a character before a camera that moves along a path. */
    along(bytes, path, ...words) {
      const [model, keys] = ['moved.glb', 'path.json'].map((name) => join(folder, name));
      writeFileSync(model, bytes);
      writeFileSync(keys, path);
      return JSON.parse(run('lod', model, '--json', '--camera-path', keys, ...words)).camera_path;
    },
    /** A character or a motion of it in another format. */
    converted(bytes, to, ...words) {
      const [from, made] = [join(folder, 'given.glb'), join(folder, `made.${to}`)];
      writeFileSync(from, bytes);
      run('convert', from, made, '--force', '--quiet', ...words);
      return readFileSync(made);
    },
    /** The description of a stream under a name. */
    described(bytes, name) {
      const file = join(folder, name);
      writeFileSync(file, bytes);
      return run('gbsd', file).trimEnd();
    },
    /** Facial animation parameters as a stream. */
    encodedFace(bytes, settings) {
      const [from, made] = ['speech.fap', 'speech.afp'].map((name) => join(folder, name));
      writeFileSync(from, bytes);
      run('convert', from, made, '--force', '--quiet', '--stream', settings);
      return readFileSync(made);
    },
    /** The report about a character in 2D. */
    flattened(bytes, to, ...words) {
      const [from, made] = [join(folder, 'given.glb'), join(folder, to)];
      writeFileSync(from, bytes);
      return JSON.parse(run('flatten', from, made, '--force', '--json', ...words));
    },
    /** A file in fewer bytes, and the report about it. */
    optimized(bytes, ...words) {
      const [from, to] = ['heavy.glb', 'lighter.glb'].map((name) => join(folder, name));
      writeFileSync(from, bytes);
      const report = JSON.parse(run('optimize', from, to, '--force', '--json', ...words));
      return { report, bytes: readFileSync(to) };
    },
    /** Names of the joints that an expression chooses, from the profile that the program writes. */
    joints(expression) {
      const profile = join(folder, 'loa.json');
      run('lod', file, '--loa', expression, '--distances', '16', '--write', `loa-profile=${profile}`, '--force', '--json');
      return JSON.parse(readFileSync(profile, 'utf8')).joints.plus;
    },
    end: () => rmSync(folder, { recursive: true }),
  };
}
