// The golden buffers of a crowd and the poses that they must show, for tests.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { readFolder } from "./crowd_buffers.mjs";

const golden = join(dirname(fileURLToPath(import.meta.url)), "../crates/articula/tests/golden/crowd");
/** Folders of golden buffers: one for each form of palettes, and two with stepped draws. */
export const FRAMES = ["matrix", "half", "rigid", "half-rigid", "matrix-stepped", "half-stepped"];
/** Buffers of a folder. */
export const open = (frame) => readFolder(join(golden, frame));
/** Poses of the plain path, and the skins whose joints they are of. */
export const expectedOf = (frame) => JSON.parse(readFileSync(join(golden, frame, "expected.json"), "utf8"));

/** Greatest difference of two lists of numbers. */
export function apart(a, b) {
  assert.equal(a.length, b.length);
  return Math.max(0, ...a.map((value, i) => Math.abs(value - b[i])));
}

/** Entry that a joint of a skin has, found as the page says: by name and inverse bind matrix. */
export function entryOf(entries, joint, inverseBind) {
  const is = (entry) => entry.joint === joint && apart(entry.inverse_bind, inverseBind) < 1e-5;
  const found = entries.map(is);
  assert.equal(found.filter(Boolean).length, 1, `${joint} has one entry`);
  return found.indexOf(true);
}
