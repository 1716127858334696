// Golden buffers of a crowd show the poses that the plain path has computed, for every form of palettes;
// and buffers that contradict their description are refused.

import assert from "node:assert/strict";
import { test } from "node:test";
import { decode, half, meshOf } from "./crowd_buffers.mjs";
import { apart, entryOf, expectedOf, FRAMES, open } from "./crowd_golden.mjs";

/** Greatest difference between decoded and expected matrices of all characters. */
function greatest({ manifest }, characters, expected) {
  let most = 0;
  for (const wanted of expected.characters) {
    const found = characters.find(({ character }) => character === wanted.character);
    wanted.matrices.forEach((matrices, skin) => {
      const { joints, inverse_bind } = expected.skins[skin];
      matrices.forEach((matrix, j) => {
        const entry = entryOf(manifest.entries, joints[j], inverse_bind[j]);
        assert.equal(entry < found.matrices.length, matrix !== null, `entry ${entry} at level ${found.level}`);
        if (matrix) most = Math.max(most, apart(found.matrices[entry], matrix));
      });
    });
  }
  return most;
}

for (const frame of FRAMES) {
  // Halves of numbers up to 2 are exact to a thousandth, also after a blend; those of a quaternion count double.
  const tolerance = frame.startsWith("half") ? 2e-3 : 2e-6;

  test(`${frame}: every matrix of every character is that of the plain path`, () => {
    const all = open(frame);
    assert.equal(all.manifest.form, frame.replace("-stepped", ""));
    const characters = decode(all);
    const expected = expectedOf(frame);
    const facts = ({ character, level, source }) => ({ character, level, source });
    const byNumber = (a, b) => a.character - b.character;
    assert.deepEqual(characters.map(facts).sort(byNumber), expected.characters.map(facts).sort(byNumber));
    const most = greatest(all, characters, expected);
    assert.ok(most < tolerance, `${most}`);
    for (const { character, morph_weights, world } of expected.characters) {
      const found = characters.find((c) => c.character === character);
      assert.ok(apart(found.world, world) < 2e-6 * 400);
      // Whoever has no set, near ones whose face rests too, is shown with the defaults.
      const { morph_defaults } = all.manifest;
      const shown = [found, { morph_weights }].map((one) => one.morph_weights ?? morph_defaults);
      assert.ok(apart(...shown) < 1e-6);
    }
  });

  test(`${frame}: a vertex has entries of its level, and weights with the sum 1`, () => {
    const all = open(frame);
    all.manifest.levels.forEach((level, l) => {
      const { vertices, triangles } = meshOf(all, l);
      for (const { influences, normal } of vertices) {
        const sum = influences.reduce((total, { weight }) => total + weight, 0);
        assert.ok(Math.abs(sum - 1) < 1e-6 && Math.abs(Math.hypot(...normal) - 1) < 1e-5);
      }
      assert.ok(triangles.flat().every((corner) => corner < level.vertices));
      assert.equal(level.parts.at(-1).first + level.parts.at(-1).count, level.triangles);
    });
  });
}

/** The bits of 1 as a float. */
const ONE = 0x3f800000;

test("what is off by one is seen", () => {
  const all = open("matrix");
  const stepped = open("matrix-stepped");
  const changed = (all, name, at, value) => {
    const bytes = Uint8Array.from(all.files[name]);
    new DataView(bytes.buffer).setUint32(at, value, true);
    return { ...all, files: { ...all.files, [name]: bytes } };
  };
  const read = ({ files }, name, at) => new DataView(files[name].buffer, files[name].byteOffset).getUint32(at, true);
  const faults = {
    "another palette": ["matrix", changed(all, "draws", 4, read(all, "draws", 4) + 1)],
    "another key": ["matrix", changed(all, "records", 0, read(all, "records", 0) + 1)],
    "another blend": ["matrix", changed(all, "records", 8, ONE)],
    "another step": ["matrix-stepped", changed(stepped, "stepped", 4, read(stepped, "stepped", 4) + 1)],
  };
  for (const [what, [frame, buffers]] of Object.entries(faults)) {
    assert.ok(greatest(buffers, decode(buffers), expectedOf(frame)) > 1e-3, what);
  }
});

test("buffers that contradict their manifest are refused", () => {
  const all = open("half");
  const but = (change) => {
    const manifest = structuredClone(all.manifest);
    change(manifest);
    return () => decode({ manifest, files: all.files });
  };
  assert.throws(but((m) => (m.version = 1)), /version 1/);
  assert.throws(but((m) => (m.stepped.first_morph_set += 1)), /stepped/);
  assert.throws(but((m) => (m.form = "quarter")), /quarter/);
  assert.throws(but((m) => (m.form = "matrix")), /bytes/);
  assert.throws(but((m) => (m.bytes["draws.bin"] += 8)), /draws/);
  assert.throws(but((m) => (m.records.groups[0].count += 1)), /groups/);
  assert.throws(but((m) => (m.draws.groups = [])), /groups/);
});

test("halves by hand", () => {
  const cases = [
    [0x0000, 0],
    [0x0001, 2 ** -24],
    [0x3c00, 1],
    [0xc000, -2],
    [0x3555, 0.333251953125],
    [0x7bff, 65504],
    [0xfc00, -Infinity],
  ];
  for (const [bits, number] of cases) assert.equal(half(bits), number);
  assert.ok(Number.isNaN(half(0x7e00)));
});
