// Lets the Khronos glTF validator judge files: `node validate.mjs FILE...`.
// Prints one JSON array with an entry a file: {file, errors, warnings, infos, messages}.
// Ends with 1 if any file has errors, 2 on wrong usage.

import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";
import validator from "gltf-validator";

/** Messages kept for each file; the counts are those of all of them. */
const MESSAGES_MAX = 20;

/** Judges one file; what lies beside it is read from its folder. */
async function judge(file) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: file,
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(resolve(dirname(file), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  const worstFirst = [...messages].sort((a, b) => a.severity - b.severity);
  return {
    file,
    errors: numErrors,
    warnings: numWarnings,
    infos: numInfos,
    messages: worstFirst
      .slice(0, MESSAGES_MAX)
      .map(({ code, message, pointer }) => ({ code, message, pointer })),
  };
}

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node validate.mjs FILE...");
  process.exit(2);
}
const verdicts = [];
for (const file of files) {
  verdicts.push(await judge(file));
}
console.log(JSON.stringify(verdicts, null, 1));
process.exitCode = verdicts.some((verdict) => verdict.errors > 0) ? 1 : 0;
