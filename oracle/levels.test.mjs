// Levels as they are drawn, on the worked example of the extension's page.

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
  spawnSync(process.execPath, [join(here, "levels.mjs"), ...words], { encoding: "utf8" });

const VERSION_2 = {
  version: 2,
  vertices: [6, 5, 4],
  clusters: [
    { first: 0, last: 0, triangles: 4 },
    { first: 0, last: 1, triangles: 2 },
    { first: 2, last: 2, triangles: 2 },
    { first: 1, last: 1, triangles: 2 },
  ],
};

/** The same as the first version had it, counted from the coarsest. */
const VERSION_1 = {
  vertices: [4, 5, 6],
  clusters: [
    { first: 2, last: 2, triangles: 4 },
    { first: 1, last: 2, triangles: 2 },
    { first: 0, last: 0, triangles: 2 },
    { first: 1, last: 1, triangles: 2 },
  ],
};

/** A square with its centre and a point between that and a corner, below a node 1 m up. */
function writeSquare(version) {
  const places = new Float32Array([0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 1, 1, 0, 1.5, 1.5, 0]);
  const finest = [1, 5, 4, 5, 3, 4, 1, 2, 5, 2, 3, 5, 0, 1, 4, 3, 0, 4];
  const corners = new Uint16Array([...finest, 1, 2, 0, 2, 3, 0, 1, 2, 4, 2, 3, 4]);
  const bytes = Buffer.concat([Buffer.from(places.buffer), Buffer.from(corners.buffer)]);
  const levels = { indices: 2, ...version };
  const extensions = { ARTICULA_clustered_mesh: levels };
  const document = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, translation: [0, 0, 1] }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, extensions }] }],
    buffers: [{ byteLength: bytes.length, uri: `data:;base64,${bytes.toString("base64")}` }],
    bufferViews: [
      { buffer: 0, byteLength: 72 },
      { buffer: 0, byteOffset: 72, byteLength: 60 },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 6, type: "VEC3", min: [0, 0, 0], max: [2, 2, 0] },
      { bufferView: 1, componentType: 5123, count: 18, type: "SCALAR" },
      { bufferView: 1, componentType: 5123, count: 30, type: "SCALAR" },
    ],
  };
  const file = join(folder, "square.gltf");
  writeFileSync(file, JSON.stringify(document));
  return file;
}

for (const [name, version] of Object.entries({ VERSION_1, VERSION_2 })) {
  test(`levels draw the triangles of their clusters, ${name}`, () => {
    const { status, stdout } = run(writeSquare(version));
    assert.equal(status, 0);
    const [{ node, groups, corners }] = JSON.parse(stdout);
    assert.equal(node, 0);
    assert.deepEqual(groups, [1, 2, 1]);
    assert.deepEqual(corners.map((level) => level.length / 9), [6, 4, 2]);
    assert.deepEqual(corners[2], [2, 0, 1, 2, 2, 1, 0, 0, 1, 2, 2, 1, 0, 2, 1, 0, 0, 1]);
  });
}

test("wrong usage is told", () => {
  assert.equal(run().status, 2);
});
