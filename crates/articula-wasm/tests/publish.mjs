// The module of what is published.
import { test } from "node:test";
import assert from "node:assert/strict";
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
