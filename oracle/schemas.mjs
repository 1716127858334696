// Judges the extensions of files by their JSON schemas: `node schemas.mjs FOLDER FILE...`.
// FOLDER holds schemas called OWNER.EXTENSION.schema.json, where OWNER is glTF, node, skin, animation
// or mesh.primitive, or EXTENSION.schema.json for all owners.
// Prints one JSON array with an entry a file: {file, judged, faults}; `judged` counts the extension
// objects that have a schema. Ends with 1 if any file has faults, 2 on wrong usage.

import { readFile, readdir } from "node:fs/promises";
import { join } from "node:path";
import Ajv from "ajv/dist/2020.js";

/** The two schemas of glTF 2.0 that those of extensions refer to. */
const CORE = [
  { $id: "glTFid.schema.json", type: "integer", minimum: 0 },
  {
    $id: "glTFProperty.schema.json",
    type: "object",
    properties: { extensions: { type: "object" }, extras: {} },
  },
];

/** The JSON of a GLB or of a glTF text. */
function document(bytes) {
  const isBinary = bytes.toString("latin1", 0, 4) === "glTF";
  const text = isBinary ? bytes.subarray(20, 20 + bytes.readUInt32LE(12)) : bytes;
  return JSON.parse(text.toString("utf8"));
}

/** Every object that may carry extensions of the kinds that are judged, and its path. */
function* owners(json) {
  yield ["glTF", "", json];
  for (const [kind, key] of [["node", "nodes"], ["skin", "skins"], ["animation", "animations"]]) {
    for (const [i, owner] of (json[key] ?? []).entries()) {
      yield [kind, `/${key}/${i}`, owner];
    }
  }
  for (const [i, mesh] of (json.meshes ?? []).entries()) {
    for (const [j, owner] of mesh.primitives.entries()) {
      yield ["mesh.primitive", `/meshes/${i}/primitives/${j}`, owner];
    }
  }
}

const [folder, ...files] = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node schemas.mjs FOLDER FILE...");
  process.exit(2);
}
const ajv = new Ajv({ allErrors: true, strict: false });
ajv.addSchema(CORE);
for (const name of await readdir(folder)) {
  if (name.endsWith(".schema.json")) {
    ajv.addSchema(JSON.parse(await readFile(join(folder, name), "utf8")), name);
  }
}
const verdicts = [];
for (const file of files) {
  const verdict = { file, judged: 0, faults: [] };
  for (const [kind, path, owner] of owners(document(await readFile(file)))) {
    for (const [name, value] of Object.entries(owner.extensions ?? {})) {
      const validate = ajv.getSchema(`${kind}.${name}.schema.json`) ?? ajv.getSchema(`${name}.schema.json`);
      if (validate === undefined) {
        continue;
      }
      verdict.judged += 1;
      if (!validate(value)) {
        const at = `${path}/extensions/${name}`;
        verdict.faults.push(...validate.errors.map((e) => `${at}${e.instancePath}: ${e.message}`));
      }
    }
  }
  verdicts.push(verdict);
}
console.log(JSON.stringify(verdicts, null, 1));
process.exitCode = verdicts.some((verdict) => verdict.faults.length > 0) ? 1 : 0;
