// Skinned positions, on a case worked by hand.

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

const run = (...words) =>
  spawnSync(process.execPath, [join(here, "skinned_positions.mjs"), ...words], { encoding: "utf8" });

/** Three corners that follow a joint 2 m up, one of them by half, below a node that must not count. */
function writeTriangle() {
  const floats = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0.5, 0.5, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
  const joints = new Uint8Array([0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
  const bytes = Buffer.concat([Buffer.from(floats.buffer), Buffer.from(joints.buffer)]);
  const document = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0, 2] }],
    nodes: [{ children: [1] }, { translation: [0, 2, 0] }, { translation: [9, 9, 9], mesh: 0, skin: 0 }, { mesh: 0 }],
    skins: [{ joints: [0, 1] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, WEIGHTS_0: 1, JOINTS_0: 2 } }] }],
    buffers: [{ byteLength: bytes.length, uri: `data:;base64,${bytes.toString("base64")}` }],
    bufferViews: [
      { buffer: 0, byteLength: 36 },
      { buffer: 0, byteOffset: 36, byteLength: 48 },
      { buffer: 0, byteOffset: 84, byteLength: 12 },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 3, type: "VEC4" },
      { bufferView: 2, componentType: 5121, count: 3, type: "VEC4" },
    ],
  };
  const path = join(folder, "triangle.gltf");
  writeFileSync(path, JSON.stringify(document));
  return path;
}

test("vertices follow their joints, and not the node of their mesh", () => {
  const { status, stdout, stderr } = run(writeTriangle());
  assert.equal(status, 0, stderr);
  const primitives = JSON.parse(stdout);
  assert.equal(primitives.length, 1, "a node outside the scene shows nothing");
  assert.equal(primitives[0].node, 2);
  assert.equal(primitives[0].normals, null);
  const wanted = [0, 1, 0, 1, 2, 0, 0, 3, 0];
  primitives[0].positions.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) < 1e-6, `${primitives[0].positions}`));
});

test("no file is refused", () => assert.equal(run().status, 2));
