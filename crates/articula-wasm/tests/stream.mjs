// The module of characters that arrive; web/test has a server.
import { test } from "node:test";
import assert from "node:assert/strict";
import { load } from "./load.mjs";

const { Client } = await load("stream");

test("a manifest is asked for first, once, and again after a pause when nothing came", () => {
  const client = new Client();
  assert.equal(client.add("knight"), 0);
  const asked = client.request(0);
  assert.deepEqual([asked.manifest, asked.known, asked.object], ["knight", undefined, undefined]);
  assert.equal(client.request(0.1), undefined);
  client.answerNothing(asked.id, 1);
  assert.equal(client.request(1), undefined);
  const again = client.request(9);
  assert.equal(again.manifest, "knight");
  assert.notEqual(again.id, asked.id);
  client.frame(9, 0.02);
  assert.equal(client.arrival(0), undefined);
  assert.equal(JSON.parse(client.report(0)).bytes, 0);
  client.free();
});

test("a malformed manifest and message, and an unknown context, are refused", () => {
  assert.throws(() => new Client('{"networks": {}}'), { name: "ArticulaError", code: "argument" });
  assert.throws(() => new Client('{"network": {"available_bps": -1}}'), { name: "ArticulaError", file: "context" });
  const client = new Client();
  client.add("knight");
  const { id } = client.request(0);
  const nothing = new TextEncoder().encode("{}");
  assert.throws(() => client.answerManifest(id, nothing, true, 0.1), { name: "ArticulaError", file: "knight" });
  assert.equal(client.hello(0.2)[0], 1);
  assert.throws(() => client.take(new Uint8Array([0x7f]), 0.3), { name: "ArticulaError", file: "knight" });
  client.free();
});
