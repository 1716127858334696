// The module of preparation and conversion.
import { test } from "node:test";
import assert from "node:assert/strict";
import { load, prepared } from "./load.mjs";

const { Tools } = await load("tools");
const { Asset } = await load("play");
const bytes = prepared();

test("progress is told, and false cancels", () => {
  const told = [];
  const stop = (part, done, total) => told.push([part, done, total]) < 2;
  assert.throws(() => Tools.prepare(bytes, "knight.glb", undefined, stop), { name: "ArticulaError", code: "cancelled" });
  assert.equal(told.length, 2);
  assert.ok(told.every(([part, done, total]) => part.length > 0 && done <= total));
});

test("what a callback throws is thrown", () => {
  const fault = new RangeError("enough");
  const stop = () => {
    throw fault;
  };
  assert.throws(() => Tools.prepare(bytes, "knight.glb", undefined, stop), fault);
});

test("a character becomes a motion, and moves another", () => {
  const motion = Tools.convert(bytes, "knight.glb", "bvh");
  assert.match(new TextDecoder().decode(motion.subarray(0, 9)), /^HIERARCHY/);
  const moved = Tools.addClips(bytes, "knight.glb", motion, "walk.bvh", '{"prefix": "my "}');
  const asset = Asset.open(moved, "moved.glb");
  assert.equal(asset.clips.length, 2);
  assert.match(asset.clips[1], /^my /);
  asset.free();
});

test("a motion is that of the joints that are chosen alone", () => {
  const [all, some] = [undefined, '{"loa": "loa(Low)"}'].map((options) => Tools.convert(bytes, "knight.glb", "abp", options));
  assert.ok(some.length < all.length, `${some.length} of ${all.length} bytes`);
  const refused = { name: "ArticulaError", code: "argument" };
  assert.throws(() => Tools.convert(bytes, "knight.glb", "abp", '{"loa": "loa(Low) +"}'), refused);
  assert.throws(() => Tools.convert(bytes, "knight.glb", "abp", '{"loa": "joint(none)"}'), refused);
  assert.throws(() => Tools.convert(bytes, "knight.glb", "abp", '{"passive": "asleep"}'), refused);
});

test("a file is described", () => {
  const found = JSON.parse(Tools.inspect(bytes, "knight.glb"));
  assert.equal(found.clips.length, 1);
  assert.ok(found.skeletons[0].joints > 20);
});

test("options that are unknown and formats that are not written are refused", () => {
  const refused = { name: "ArticulaError", code: "argument" };
  assert.throws(() => Tools.prepare(bytes, "knight.glb", '{"levels": 3}'), refused);
  assert.throws(() => Tools.prepare(bytes, "knight.glb", '{"meshLevels": 0}'), refused);
  assert.throws(() => Tools.convert(bytes, "knight.glb", "doc"), refused);
  assert.throws(() => Tools.convert(bytes, "knight.glb", "fbx"), refused);
  assert.throws(() => Tools.inspect(new Uint8Array(3), "none.glb"), { name: "ArticulaError", code: "invalid", file: "none.glb" });
});
