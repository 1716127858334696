// The walker of MP4 files, on a file laid out by hand.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";

const script = join(dirname(fileURLToPath(import.meta.url)), "mp4_samples.mjs");
const folder = mkdtempSync(join(tmpdir(), "articula-mp4-"));
after(() => rmSync(folder, { recursive: true }));

/** A box of texts and of numbers with 32 bits. */
function box(name, ...parts) {
  const bytes = (part) => {
    if (typeof part === "string") return Buffer.from(part, "latin1");
    if (Buffer.isBuffer(part)) return part;
    const number = Buffer.alloc(4);
    number.writeUInt32BE(part);
    return number;
  };
  const body = Buffer.concat(parts.map(bytes));
  return Buffer.concat([bytes(8 + body.length), bytes(name), body]);
}

/** Three samples `a`, `bc` and `def` in two chunks of the file, with half a second each. */
function mp4(change = {}) {
  const made = (offset) => {
    const stbl = box(
      "stbl",
      box("stsd", 0, 1, box("urim", 0, 1, box("uri ", 0, "urn:x\0"), box("uriI", 0, "HEAD"))),
      box("stts", 0, 1, 3, change.delta ?? 5),
      box("stsc", 0, 2, 1, 2, 1, 2, 1, 1),
      box("stsz", 0, 0, 3, 1, 2, 3),
      box("stco", 0, 2, offset, offset + 3),
    );
    const dinf = box("dinf", box("dref", 0, 1, box("url ", 1)));
    const mdia = box(
      "mdia",
      box("mdhd", 0, 0, 0, 10, 15, 0),
      box("hdlr", 0, 0, "meta", 0, 0, 0, "\0\0\0\0"),
      box("minf", box("nmhd", 0), dinf, stbl),
    );
    const trak = box("trak", box("tkhd", 3, 0, 0, 7, 0, 15), mdia);
    return box("moov", box("mvhd", 0, 0, 0, 10, 15), trak);
  };
  const ftyp = box("ftyp", "isom", 0, "isom");
  const offset = ftyp.length + made(0).length + 8 + (change.shift ?? 0);
  const path = join(folder, "a.mp4");
  writeFileSync(path, Buffer.concat([ftyp, made(offset), box("mdat", "abcdef", change.tail ?? "")]));
  return path;
}

const run = (path) => spawnSync(process.execPath, [script, path], { encoding: "utf8" });

test("samples are found through the tables", () => {
  const { status, stdout } = run(mp4());
  assert.equal(status, 0);
  const { brands, duration_secs, tracks } = JSON.parse(stdout);
  assert.deepEqual([brands, duration_secs, tracks.length], [["isom"], 1.5, 1]);
  const { id, handler, entry, uri, init, timescale, samples } = tracks[0];
  assert.deepEqual([id, handler, entry, uri, timescale], [7, "meta", "urim", "urn:x", 10]);
  assert.equal(Buffer.from(init, "hex").toString(), "HEAD");
  const texts = samples.map((sample) => Buffer.from(sample.bytes, "hex").toString());
  assert.deepEqual(texts, ["a", "bc", "def"]);
  assert.deepEqual(samples.map((sample) => sample.secs), [0, 0.5, 1]);
});

test("a file whose numbers disagree is refused", () => {
  for (const [change, why] of [
    [{ shift: 1 }, /sample 2 outside of mdat/],
    [{ delta: 4 }, /do not add up/],
    [{ tail: "g" }, /mdat has 7 bytes, samples 6/],
  ]) {
    const { status, stderr } = run(mp4(change));
    assert.equal(status, 1);
    assert.match(stderr, why);
  }
});
