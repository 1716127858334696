// The sizes that Draco gives: what comes back is the mesh, and more attributes take more bytes.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "articula-oracle-"));
after(() => rmSync(folder, { recursive: true }));

const run = (...words) => spawnSync(process.execPath, [join(here, "draco.mjs"), ...words], { encoding: "utf8" });

/** A sheet of `side` by `side` squares, wavy, with one joint number a vertex. */
function writeSheet(side, cut = 0) {
  const positions = [];
  const joints = [];
  const indices = [];
  for (let y = 0; y <= side; y++) {
    for (let x = 0; x <= side; x++) {
      positions.push(x, y, Math.sin(x * 0.7) * Math.cos(y * 0.9));
      joints.push(x % 5);
      if (x < side && y < side) {
        const a = y * (side + 1) + x;
        indices.push(a, a + 1, a + side + 1, a + 1, a + side + 2, a + side + 1);
      }
    }
  }
  const arrays = [new Float32Array(positions), new Uint32Array(indices), new Uint8Array(joints)];
  const [position, index, joint] = arrays.map((array) => Buffer.from(array.buffer));
  const head = {
    meshes: [
      {
        name: "sheet",
        steps: true,
        vertices: joints.length,
        triangles: indices.length / 3,
        indices: position.length,
        attributes: [
          { kind: "POSITION", size: 3, type: "f32", offset: 0, bits: 14, origin: [0, 0, -1], range: side },
          { kind: "GENERIC", size: 1, type: "u8", offset: position.length + index.length },
        ],
      },
    ],
  };
  const json = Buffer.from(JSON.stringify(head));
  const length = Buffer.alloc(4);
  length.writeUInt32LE(json.length);
  const path = join(folder, `sheet${side}-${cut}.bin`);
  const whole = Buffer.concat([length, json, position, index, joint]);
  writeFileSync(path, whole.subarray(0, whole.length - cut));
  return path;
}

test("a sheet comes back whole, and everything that it has takes bytes", () => {
  const { status, stdout, stderr } = run(writeSheet(20));
  assert.equal(status, 0, stderr);
  const [sheet] = JSON.parse(stdout);
  assert.equal(sheet.vertices, 21 * 21);
  assert.equal(sheet.triangles, 800);
  assert.equal(sheet.steps.length, 2);
  assert.ok(0 < sheet.connectivity && sheet.connectivity < sheet.steps[0]);
  assert.ok(sheet.steps[0] < sheet.steps[1]);
  assert.equal(sheet.bytes, sheet.steps[1]);
  // Two bits for a vertex's connectivity and 14 for each coordinate, and its joint.
  assert.ok(sheet.bytes < (21 * 21 * (2 + 3 * 14 + 8)) / 8);
});

test("a file that ends early is refused", () => {
  assert.notEqual(run(writeSheet(20, 5)).status, 0);
  assert.equal(run().status, 2);
});
