// The independent reader and writer of MPEG-4's face streams: bits worked by hand, its golden
// streams, and a stream written by Articula.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";
import { decode, encode, frames } from "./fba.mjs";
import { clips } from "./fba_clips.mjs";
import { BitReader, BitWriter, Model, RunReader, RunWriter } from "./fba_run.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "articula-oracle-"));
after(() => rmSync(folder, { recursive: true }));
const kept = (name) => readFileSync(join(here, "../crates/articula-stream/tests/golden", name));
const run = (...words) => spawnSync(process.execPath, [join(here, "fba.mjs"), ...words], { encoding: "utf8" });

const NEW = [null, null, null, null];

test("a run has the bits that its intervals say", () => {
  const out = new BitWriter();
  const coder = new RunWriter(out);
  // The middle of three: 21845 to 43689. Doubled about the middle 10922 to 54611. Its first third
  // from below, symbol 2: 10922 to 25484, so 0 and the pending 1; 21844 to 50969; no more. Then 1 and 0.
  const model = new Model({ least: 0, greatest: 2 });
  coder.symbol(model, 1);
  coder.symbol(model, 2);
  coder.end();
  assert.deepEqual(out.bits, [0, 1, 1, 0]);
});

test("a run of no symbol has two bits", () => {
  const out = new BitWriter();
  new RunWriter(out).end();
  assert.deepEqual(out.bits, [0, 1]);
  const from = new BitReader(Uint8Array.of(0b01111111, 0xff, 0xff));
  new RunReader(from).end();
  assert.equal(from.at, 2);
});

test("the streams that are kept are those of the clips, and are read again", () => {
  for (const [name, planes] of Object.entries(clips)) {
    const { bytes, planes: shown } = encode(planes);
    assert.deepEqual(Buffer.from(bytes), kept(`${name}.fba`), name);
    assert.equal(frames(shown), kept(`${name}.txt`).toString(), name);
    const found = decode(bytes);
    assert.equal(frames(found), frames(shown), name);
    assert.deepEqual(Buffer.from(encode(found).bytes), kept(`${name}.fba`), name);
  }
});

test("they have runs that end in 22 zeros, and inserted bits", (t) => {
  const ends = [];
  const end = RunWriter.prototype.end;
  t.mock.method(RunWriter.prototype, "end", function () {
    end.call(this);
    ends.push(this.zeros);
  });
  let inserted = 0;
  const put = RunWriter.prototype.put;
  t.mock.method(RunWriter.prototype, "put", function (bit) {
    if (this.zeros === 22) inserted++;
    put.call(this, bit);
  });
  encode(clips["fba-zeros"]);
  assert.ok(ends.includes(22));
  assert.ok(inserted > 20, `${inserted}`);
});

test("a stream of Articula gives the frames that Articula reads in it", () => {
  const planes = decode(kept("fba-own.fba"));
  assert.equal(frames(planes), kept("fba-own.txt").toString());
  assert.deepEqual(planes[0].frameRate, [30, 0, 1]);
  assert.deepEqual(planes[0].timeCode, [1, 59, 7]);
  // The same planes have the same bytes.
  assert.deepEqual(Buffer.from(encode(planes).bytes), kept("fba-own.fba"));
});

test("the program writes what it reads", () => {
  const [plan, file] = ["plan.json", "out.fba"].map((name) => join(folder, name));
  writeFileSync(plan, JSON.stringify(clips["fba-wild"]));
  assert.equal(run("encode", plan, file).status, 0);
  assert.deepEqual(readFileSync(file), kept("fba-wild.fba"));
  assert.equal(run("frames", file).stdout, kept("fba-wild.txt").toString());
  assert.equal(JSON.parse(run("decode", file).stdout).length, 14);
});

test("what is no such stream is refused", () => {
  const masks = ["0", "0", "3", ...Array(7).fill("0")];
  const { bytes } = encode([{ intra: true, quantiser: 1, masks, ranges: NEW, values: {} }]);
  const changed = (at) => bytes.map((byte, i) => (i === at >> 3 ? byte ^ (128 >> (at & 7)) : byte));
  assert.throws(() => decode(changed(30)), /fba_object_start_code/);
  assert.throws(() => decode(changed(33)), /not of a face alone/);
  assert.throws(() => decode(bytes.slice(0, bytes.length - 1)));
  // After the head: is_intra, mask, rate, time, skip, quantiser, ten groups of three bits, gender.
  assert.throws(() => decode(changed(32 + 1 + 2 + 1 + 1 + 1 + 5 + 30 + 1)), /DCT/);
  assert.equal(run("frames", join(here, "fba.mjs")).status, 1);
  assert.equal(run().status, 2);
});
