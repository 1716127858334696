// The module of what is published.
import { test } from "node:test";
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { load, prepared } from "./load.mjs";

const { Publisher } = await load("publish");
const bytes = prepared();

test("options that are unknown are refused", () => {
  const refused = { name: "ArticulaError", code: "argument" };
  assert.throws(() => Publisher.flatten(bytes, "knight.glb", '{"form": "png"}'), refused);
  assert.throws(() => Publisher.package(bytes, "knight.glb", '{"meshLevels": 17}'), refused);
});

test("progress is told, and false cancels", () => {
  const stop = () => false;
  const cancelled = { name: "ArticulaError", code: "cancelled" };
  assert.throws(() => Publisher.package(bytes, "knight.glb", undefined, stop), cancelled);
});

test("an evaluation tells what joints save and show", () => {
  const found = JSON.parse(Publisher.evaluate(bytes, "knight.glb", '{"loa": "loa(Low)", "distances": [4]}'));
  assert.equal(found.rows.length, 1);
  const [{ level, joint_update_gain: gain, error_px: error }] = found.rows;
  assert.ok(level === "loa(Low)" && gain > 0.3 && gain < 1 && error.p95 > 0 && error.max >= error.p95, JSON.stringify(found));
  const refused = { name: "ArticulaError", code: "argument" };
  assert.throws(() => Publisher.evaluate(bytes, "knight.glb", '{"method": "magic"}'), { ...refused, message: /magic/ });
  assert.throws(() => Publisher.evaluate(bytes, "knight.glb", '{"loa": "loa(Low) +"}'), refused);
  assert.throws(() => Publisher.evaluate(bytes, "knight.glb", '{"distances": [0]}'), refused);
  assert.throws(() => Publisher.addFaceClip(bytes, "knight.glb", new Uint8Array(), "face.txt"), refused);
});

test("a voice needs a recording, and a face", () => {
  const voice = readFileSync(new URL("../../../assets/speech/librivox_austen_0880.wav", import.meta.url));
  // The knight has no blend shapes, and a helmet in place of a mouth. What speaks is tested in the studio.
  assert.throws(() => Publisher.addVoice(bytes, "knight.glb", voice, "austen.wav"), { name: "ArticulaError", file: "knight.glb", message: /closed face with nose and mouth/ });
  assert.throws(() => Publisher.addVoice(bytes, "knight.glb", new Uint8Array(9), "noise.wav"), { name: "ArticulaError", code: "invalid", file: "noise.wav", message: /noise.wav: not a WAV/ });
});

test("a file becomes lighter within the error that is asked for", () => {
  const options = '{"errorPx": 2, "keepTriangles": true}';
  const made = Publisher.optimize(bytes, "knight.glb", options);
  const { bytes: lighter } = made;
  const report = JSON.parse(made.report);
  made.free();
  assert.ok(lighter.length === report.bytes_out && lighter.length < bytes.length / 2, `${lighter.length} of ${bytes.length}`);
  assert.ok(report.error_mm <= report.bound_mm && report.triangles_out === report.triangles_in, JSON.stringify(report));
  const again = Publisher.optimize(lighter, "lighter.glb", options);
  assert.ok(again.bytes.length <= lighter.length);
  again.free();
  const refused = { name: "ArticulaError", code: "argument" };
  assert.throws(() => Publisher.optimize(bytes, "knight.glb", '{"errorPx": 1, "errorMm": 1}'), refused);
  assert.throws(() => Publisher.optimize(bytes, "knight.glb", '{"errorPx": -1}'), refused);
  assert.throws(() => Publisher.optimize(bytes, "knight.glb", '{"compress": "zip"}'), refused);
});

test("a device is benchmarked by content of known size", () => {
  const told = [];
  const found = JSON.parse(Publisher.benchmark(bytes, "knight.glb", '{"seconds": 0.3}', (...step) => told.push(step) > 0));
  assert.equal(found.application, "body");
  assert.ok(found.score > 0 && found.full_fps > 0 && found.reference.length === 12, JSON.stringify(found));
  assert.ok(found.grades.length > 0 && found.grades.every(({ grade, fps }) => fps > 0 && found.reference[grade].fps > 0));
  assert.ok(told.some(([part, done, total]) => part === "playing" && done <= total));
  const refused = { name: "ArticulaError", code: "argument" };
  assert.throws(() => Publisher.benchmark(bytes, "knight.glb", '{"seconds": 0}'), refused);
  assert.throws(() => Publisher.benchmark(bytes, "knight.glb", '{"application": "dog"}'), refused);
});
