// The judge of Lottie documents, on a schema of the specification's form and, where the real one
// lies beside the checkout, on its own test animations.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "articula-oracle-"));
after(() => rmSync(folder, { recursive: true }));

function run(...words) {
  const script = join(here, "lottie_schema.mjs");
  const { status, stdout } = spawnSync(process.execPath, [script, ...words], { encoding: "utf8" });
  return { status, verdicts: stdout && JSON.parse(stdout) };
}

function write(name, value) {
  mkdirSync(dirname(join(folder, name)), { recursive: true });
  writeFileSync(join(folder, name), JSON.stringify(value));
  return join(folder, name);
}

/** A kind that is told by `ty`, and the one for all other kinds. */
function kinds(kind, ty, needs) {
  const known = { allOf: [{ type: "object", properties: { ty: { const: ty } }, required: ["ty", ...needs] }] };
  write(`schema/${kind}s/known.json`, known);
  write(`schema/${kind}s/unknown-${kind}.json`, { properties: { ty: { not: { enum: [] } } } });
  write(`schema/${kind}s/all.json`, {
    oneOf: [{ $ref: `#/$defs/${kind}s/known` }, { $ref: `#/$defs/${kind}s/unknown-${kind}` }],
  });
}

test("a definition is found by its folder and file, and unknown kinds are allowed", () => {
  write("schema/root.json", { $ref: "#/$defs/composition/animation" });
  write("schema/composition/animation.json", {
    properties: { layers: { items: { $ref: "#/$defs/layers/all" } } },
    required: ["layers"],
  });
  kinds("layer", 4, ["shapes"]);
  kinds("shape", "sh", []);
  const good = write("good.json", { layers: [{ ty: 4, shapes: [] }, { ty: 999 }] });
  const bad = write("bad.json", { layers: [{ ty: 4 }] });
  writeFileSync(join(folder, "torn.json"), "{");
  const schema = join(folder, "schema");
  assert.equal(run(schema, good).status, 0);
  const { status, verdicts } = run(schema, good, bad, join(folder, "torn.json"));
  assert.equal(status, 1);
  assert.deepEqual(verdicts.map(({ faults }) => faults.length > 0), [false, true, true]);
  assert.match(verdicts[1].faults[0], /^\/layers\/0: .*shapes/);
  assert.equal(run(schema).status, 2);
});

const data = process.env.ARTICULA_DATA ?? join(here, "../../shared/data");
const spec = join(data, "fixtures/lottie_spec");
const isNeeded = process.env.ARTICULA_REQUIRE_DATA === "1";

test("the specification's own animations", { skip: existsSync(spec) || isNeeded ? false : "no data" }, () => {
  const animations = (kind) => {
    const names = readdirSync(join(spec, "tests/animations", kind));
    return names.map((name) => join(spec, "tests/animations", kind, name));
  };
  const [valid, invalid] = ["valid", "invalid"].map(animations);
  assert.ok(valid.length > 0 && invalid.length > 0);
  const { verdicts } = run(join(spec, "schema"), ...valid, ...invalid);
  const expected = [...valid.map(() => false), ...invalid.map(() => true)];
  assert.deepEqual(verdicts.map(({ faults }) => faults.length > 0), expected);
});
