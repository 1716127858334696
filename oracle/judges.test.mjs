// The judges themselves, on cases worked by hand: a judge that never refuses proves nothing.

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

/** Runs a script of this folder. */
function run(script, ...words) {
  const { status, stdout, stderr } = spawnSync(process.execPath, [join(here, script), ...words], {
    encoding: "utf8",
  });
  return { status, stdout, stderr };
}

/** Writes a glTF: an upper arm 1 m above the root turns 90 degrees about Z in one second. */
function writeArm(name, change = (document) => document) {
  const half = Math.SQRT1_2;
  const floats = new Float32Array([0, 1, /* keys */ 0, 0, 0, 1, 0, 0, half, half]);
  const uri = `data:application/octet-stream;base64,${Buffer.from(floats.buffer).toString("base64")}`;
  const document = {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [
      { name: "root", children: [1], translation: [0, 0, 0.5] },
      { name: "upper", children: [2], translation: [0, 1, 0] },
      { name: "hand", translation: [2, 0, 0] },
      { name: "elsewhere" },
    ],
    buffers: [{ byteLength: 40, uri }],
    bufferViews: [
      { buffer: 0, byteLength: 8 },
      { buffer: 0, byteOffset: 8, byteLength: 32 },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 2, type: "SCALAR", min: [0], max: [1] },
      { bufferView: 1, componentType: 5126, count: 2, type: "VEC4" },
    ],
    animations: [
      {
        name: "bend",
        channels: [{ sampler: 0, target: { node: 1, path: "rotation" } }],
        samplers: [{ input: 0, output: 1 }],
      },
    ],
  };
  const path = join(folder, name);
  writeFileSync(path, JSON.stringify(change(document)));
  return path;
}

function assertNear(found, expected) {
  assert.equal(found.length, expected.length);
  found.forEach((value, axis) => assert.ok(Math.abs(value - expected[axis]) < 1e-6, `${found}`));
}

test("a bending arm is where the sine and cosine say", () => {
  const { status, stdout } = run("joint_positions.mjs", writeArm("arm.gltf"), "0", "0", "0.5", "9");
  assert.equal(status, 0);
  const { clip, nodes, frames } = JSON.parse(stdout);
  assert.equal(clip, "bend");
  assert.deepEqual(nodes, ["root", "upper", "hand", "elsewhere"]);
  assertNear(frames[0].positions[2], [2, 1, 0.5]);
  assertNear(frames[1].positions[2], [2 * Math.SQRT1_2, 1 + 2 * Math.SQRT1_2, 0.5]);
  assertNear(frames[2].positions[2], [0, 3, 0.5]);
  assert.equal(frames[0].positions[3], null);
});

test("the rest pose needs no clip", () => {
  const { stdout } = run("joint_positions.mjs", writeArm("rest.gltf"), "rest");
  assertNear(JSON.parse(stdout).frames[0].positions[2], [2, 1, 0.5]);
});

test("a missing clip and wrong words are refused", () => {
  const arm = writeArm("clips.gltf");
  assert.equal(run("joint_positions.mjs", arm, "1", "0").status, 1);
  assert.equal(run("joint_positions.mjs", arm, "0").status, 2);
  assert.equal(run("joint_positions.mjs", arm, "0", "soon").status, 2);
});

test("the validator passes a good file and refuses a bad one", () => {
  const good = writeArm("good.gltf");
  const passed = run("validate.mjs", good);
  assert.equal(passed.status, 0, passed.stdout);
  const bad = writeArm("bad.gltf", (document) => ({
    ...document,
    nodes: [...document.nodes, { children: [99] }],
  }));
  const refused = run("validate.mjs", good, bad);
  assert.equal(refused.status, 1);
  const [first, second] = JSON.parse(refused.stdout);
  assert.equal(first.errors, 0);
  assert.ok(second.errors > 0);
  assert.equal(second.messages[0].pointer, "/nodes/4/children/0");
});

test("schemas pass a good extension and refuse a bad one", () => {
  const schema = {
    $schema: "https://json-schema.org/draft/2020-12/schema",
    allOf: [{ $ref: "glTFProperty.schema.json" }],
    properties: { rootNode: { allOf: [{ $ref: "glTFid.schema.json" }] } },
    required: ["rootNode"],
  };
  writeFileSync(join(folder, "glTF.EXT_a.schema.json"), JSON.stringify(schema));
  const arm = (name, value) =>
    writeArm(name, (document) => ({ ...document, extensions: { EXT_a: value, EXT_b: 7 } }));
  const good = arm("with.gltf", { rootNode: 0 });
  const passed = run("schemas.mjs", folder, good);
  assert.equal(passed.status, 0, passed.stderr);
  assert.equal(JSON.parse(passed.stdout)[0].judged, 1);
  const refused = run("schemas.mjs", folder, good, arm("without.gltf", { rootNode: -1 }));
  assert.equal(refused.status, 1);
  const [first, second] = JSON.parse(refused.stdout);
  assert.deepEqual(first.faults, []);
  assert.equal(second.faults.length, 1);
  assert.ok(second.faults[0].startsWith("/extensions/EXT_a/rootNode: must be >= 0"));
  assert.equal(run("schemas.mjs", folder).status, 2);
});
