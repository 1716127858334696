// The codec's judges: the kept vectors are those of the package, and the cases are as stated.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));

function run(script, ...words) {
  const { status, stdout } = spawnSync(process.execPath, [join(here, script), ...words], {
    encoding: "utf8",
    maxBuffer: 2 ** 26,
  });
  return { status, stdout };
}

test("the kept vectors are those of the package", () => {
  const kept = readFileSync(join(here, "../crates/articula-formats/tests/it/meshopt/vectors.json"), "utf8");
  const { status, stdout } = run("meshopt_vectors.mjs");
  assert.equal(status, 0);
  assert.equal(stdout, kept);
  assert.equal(JSON.parse(stdout).length, 21);
});

test("the same seed gives the same cases, of every mode and filter", () => {
  const first = run("meshopt_cases.mjs", "5", "100");
  assert.equal(first.status, 0);
  assert.equal(first.stdout, run("meshopt_cases.mjs", "5", "100").stdout);
  const cases = first.stdout.trim().split("\n").map((line) => JSON.parse(line));
  assert.equal(cases.length, 200);
  const kinds = new Set(cases.map(({ mode, filter, encoded }) => `${mode} ${filter} ${encoded.slice(0, 2)}`));
  for (const filter of ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"]) {
    for (const header of ["a0", "a1"]) {
      assert.ok(kinds.has(`ATTRIBUTES ${filter} ${header}`), `${filter} ${header}`);
    }
  }
  assert.ok(kinds.has("TRIANGLES NONE e1") && kinds.has("INDICES NONE d1"));
  for (const { count, stride, reference } of cases) {
    assert.ok(reference === null || reference.length === count * stride * 2);
  }
});

test("wrong words are refused", () => {
  assert.equal(run("meshopt_cases.mjs", "x").status, 2);
});
