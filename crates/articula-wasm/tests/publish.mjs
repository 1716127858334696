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

const copied = (files) =>
  Object.fromEntries(
    files.map((file) => {
      const copy = [file.name, file.bytes];
      file.free();
      return copy;
    }),
  );

test("a head becomes a portrait", () => {
  const files = copied(Publisher.portrait(bytes, "knight.glb", '{"triangles": 100}'));
  const text = (name) => new TextDecoder().decode(files[name]);
  const report = JSON.parse(text("report.json"));
  const document = JSON.parse(text("portrait.json"));
  assert.deepEqual(Object.keys(files).sort(), ["player.js", "portrait.html", "portrait.json", "report.json", "view0.webp", "view1.webp", "view2.webp"]);
  assert.equal(report.bytes.raw, files["portrait.html"].length);
  assert.ok(report.triangles <= 100 && report.views === document.views.length && report.error.length === 5, JSON.stringify(report));
  assert.match(text("player.js"), /class ArticulaPortrait/);
  assert.throws(() => Publisher.portrait(bytes, "knight.glb", '{"clip": "none"}'), { name: "ArticulaError", code: "argument" });
});

test("a clip is encoded in layers or in steps, and described", () => {
  const layered = copied(Publisher.encode(bytes, "knight.glb", '{"toleranceMm": 1, "tiers": 2}'));
  const [stream, description, table] = Object.keys(layered);
  assert.ok(stream.endsWith(".abp") && description === stream.replace(".abp", ".gbsd.xml") && table === "aqos.xml", `${Object.keys(layered)}`);
  const fine = copied(Publisher.encode(bytes, "knight.glb", '{"quantizer": 1}'));
  const rough = copied(Publisher.encode(bytes, "knight.glb", '{"quantizer": 31, "power": 2, "interpolated": 3}'));
  assert.deepEqual(Object.keys(fine), [stream, description]);
  assert.ok(rough[stream].length < fine[stream].length);
  const refused = { name: "ArticulaError", code: "argument" };
  for (const wrong of ['{"quantizer": 0}', '{"quantizer": 32}', '{"tiers": 9}', '{"toleranceMm": -1}', '{"groupBy": "colour"}', '{"clip": "none"}']) {
    assert.throws(() => Publisher.encode(bytes, "knight.glb", wrong), refused, wrong);
  }
  const fap = readFileSync(new URL("../../../assets/fap/speech_synthetic.fap", import.meta.url));
  const spoken = copied(Publisher.encodeFace(fap, "speech.fap", '{"quantizer": 4}'));
  assert.deepEqual(Object.keys(spoken), ["speech.afp", "speech.gbsd.xml"]);
  assert.throws(() => Publisher.encodeFace(fap, "speech.txt"), refused);
});

test("errors have the weight that is asked for", () => {
  const [stored, turned] = [undefined, '{"beta": 1}'].map((options) => Publisher.errorMatrix(bytes, "knight.glb", options));
  assert.ok(stored.length > 0 && stored.length === turned.length && Math.max(...stored) === 1 && Math.max(...turned) === 1);
  assert.ok(stored.some((error, i) => error !== turned[i]));
  assert.deepEqual(Publisher.errorMatrix(bytes, "knight.glb", '{"beta": 0.5}'), stored);
  const refused = { name: "ArticulaError", code: "argument", message: /beta: 1.5/ };
  assert.throws(() => Publisher.errorMatrix(bytes, "knight.glb", '{"beta": 1.5}'), refused);
  assert.throws(() => Publisher.evaluate(bytes, "knight.glb", '{"beta": 1.5}'), refused);
});

test("what was shown becomes a clip", () => {
  const wrong = () => Publisher.addRecording(bytes, "knight.glb", "shown", new Float32Array([0, 0.5]), new Float32Array(3), new Float32Array());
  assert.throws(wrong, { name: "ArticulaError", code: "argument", message: /joints: 3 numbers/ });
});
