// What the tests share: a module, the file that the library has prepared on this machine, and the hashes of the steps
// that it took there. `cargo xtask test` gives their places.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { join } from "node:path";

function given(name) {
  const value = process.env[name];
  if (value === undefined) throw new Error(`${name} is not set; run cargo xtask test`);
  return value;
}

/** Loads a module; `memory` is that of the module. */
export async function load(name) {
  const folder = given("ARTICULA_WASM");
  const classes = await import(pathToFileURL(join(folder, `${name}.js`)).href);
  const { memory } = classes.initSync({ module: readFileSync(join(folder, `${name}_bg.wasm`)) });
  return { ...classes, memory };
}

/** The knight of a quarter second that the library has prepared. */
export const prepared = () => new Uint8Array(readFileSync(given("ARTICULA_PREPARED")));

/** Hash of a step of the library on this machine. */
export function step(name) {
  const line = given("ARTICULA_STEPS").split("\n").find((line) => line.startsWith(`${name}: `));
  if (line === undefined) throw new Error(`there is no step ${name}`);
  return line.slice(name.length + 2);
}

/** The hash FNV-1a of 64 bits, as 16 digits. */
export class Fnv {
  // In halves, since numbers of 64 bits are slow.
  #low = 0x84222325;
  #high = 0xcbf29ce4;

  add(bytes) {
    let [low, high] = [this.#low, this.#high];
    for (const byte of bytes) {
      low = (low ^ byte) >>> 0;
      // Times 2^40 + 0x1b3.
      const carried = Math.floor((low * 0x1b3) / 2 ** 32);
      high = (Math.imul(high, 0x1b3) + carried + (low << 8)) >>> 0;
      low = Math.imul(low, 0x1b3) >>> 0;
    }
    [this.#low, this.#high] = [low, high];
  }

  text() {
    const half = (number) => number.toString(16).padStart(8, "0");
    return half(this.#high) + half(this.#low);
  }
}

/** A view from `eye` along +Z or -Z, 1280 x 720 at 45 degrees. */
export function view(eye, along) {
  const turned = along > 0 ? [0, 1, 0, 0] : [0, 0, 0, 1];
  return new Float32Array([...eye, ...turned, 1280, 720, Math.PI / 4]);
}
