// A server of characters, as `articula serve` is: the program that the tests have built.
import { execFileSync, spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { mkdtemp, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { fileURLToPath } from 'node:url';

const ROOT = fileURLToPath(new URL('../..', import.meta.url));

/** The program; undefined if it is not built. */
export const PROGRAM = [process.env.ARTICULA, join(ROOT, 'target/debug/articula')].find(
  (path) => path !== undefined && existsSync(path),
);

const QUIET = { stdio: ['ignore', 'ignore', 'inherit'] };

/**
 * Serves a character of the repository with one of its clips from a new folder, to pages of all origins; `more` are
 * words of `articula serve`, and `carried` are files that it carries, by their names: it is then packaged as an item.
 */
export async function openStore(file, clip, name, more = [], carried = {}) {
  const folder = await mkdtemp(join(tmpdir(), 'store-'));
  const character = (of) => ['convert', join(ROOT, 'assets', file), join(of, `${name}.glb`), '--clip', clip, '--quiet'];
  if (Object.keys(carried).length === 0) {
    execFileSync(PROGRAM, character(folder), QUIET);
  } else {
    const beside = await mkdtemp(join(tmpdir(), 'carried-'));
    execFileSync(PROGRAM, character(beside), QUIET);
    const files = await Promise.all(Object.entries(carried).map(async ([of, bytes]) => {
      await writeFile(join(beside, of), bytes);
      return ['--with', join(beside, of)];
    }));
    execFileSync(PROGRAM, ['package', join(beside, `${name}.glb`), join(folder, name), '--quiet', ...files.flat()], QUIET);
    await rm(beside, { recursive: true });
  }
  let running = await start(folder, '127.0.0.1:0', more);
  const { url } = running;
  const stop = () =>
    new Promise((resolve) => {
      const { child } = running;
      if (child.exitCode !== null || child.signalCode !== null) {
        resolve();
        return;
      }
      child.once('exit', resolve);
      child.kill('SIGKILL');
    });
  return {
    url,
    stop,
    async start() {
      running = await start(folder, new URL(url).host, more);
    },
    async close() {
      await stop();
      await rm(folder, { recursive: true, force: true });
    },
  };
}

/** Starts the program; resolves when it listens. */
async function start(folder, address, more) {
  const words = ['serve', folder, '--addr', address, '--allow-origin', '*', '--json', ...more];
  const child = spawn(PROGRAM, words, { stdio: ['ignore', 'pipe', 'inherit'] });
  // Nothing of a test outlives it.
  const end = () => child.kill('SIGKILL');
  process.once('exit', end);
  child.once('exit', () => process.off('exit', end));
  let said = '';
  for await (const line of createInterface({ input: child.stdout })) {
    said += line;
    const url = /"url":\s*"([^"]+)"/.exec(said)?.[1];
    if (url !== undefined) {
      return { child, url };
    }
  }
  throw new Error('articula serve has ended');
}
