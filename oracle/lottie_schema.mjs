// Judges Lottie documents by the schema of the Lottie specification:
// `node lottie_schema.mjs FOLDER FILE...`. FOLDER is the specification's `schema`, one definition
// a file; root.json names them as #/$defs/FOLDER/FILE. Kinds of shapes and layers that the
// specification does not know are allowed: those lists are left empty in the files and filled here.
// Prints one JSON array with an entry a file: {file, faults}. Ends with 1 if any file has faults,
// 2 on wrong usage.

import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import Ajv from "ajv/dist/2020.js";

const read = (path) => JSON.parse(readFileSync(path, "utf8"));

/** The schema in one piece. */
function schemaOf(folder) {
  const $defs = {};
  for (const part of readdirSync(folder, { withFileTypes: true })) {
    if (!part.isDirectory()) continue;
    const names = readdirSync(join(folder, part.name)).filter((name) => name.endsWith(".json"));
    const defs = names.map((name) => [name.slice(0, -".json".length), read(join(folder, part.name, name))]);
    $defs[part.name] = Object.fromEntries(defs);
  }
  for (const kind of ["shape", "layer"]) {
    const all = $defs[`${kind}s`];
    all[`unknown-${kind}`].properties.ty.not.enum = Object.values(all).flatMap(typesOf);
  }
  return { ...read(join(folder, "root.json")), $defs };
}

/** The value of `ty` that a definition asks for, if it does. */
function typesOf(definition) {
  const types = (definition.allOf ?? []).map((part) => part.properties?.ty?.const);
  return types.filter((type) => type !== undefined);
}

/** What is wrong with a document, or with its being JSON at all. */
function faultsOf(validate, file) {
  let document;
  try {
    document = read(file);
  } catch (error) {
    return [String(error.message)];
  }
  if (validate(document)) return [];
  return validate.errors.map((error) => `${error.instancePath}: ${error.message}`);
}

const [folder, ...files] = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node lottie_schema.mjs FOLDER FILE...");
  process.exit(2);
}
const ajv = new Ajv({ strict: false });
const validate = ajv.compile(schemaOf(folder));
const verdicts = files.map((file) => ({ file, faults: faultsOf(validate, file) }));
console.log(JSON.stringify(verdicts, null, 1));
process.exitCode = verdicts.some(({ faults }) => faults.length > 0) ? 1 : 0;
