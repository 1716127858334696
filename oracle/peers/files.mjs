// The file of every peer for one source: `node files.mjs SOURCE FOLDER [PART]`. Pictures stay as they are; with PART,
// such as 0.7, that part of the triangles is asked for.
// Prints [{peer, setting, file, fault}]: the file's path, or why there is none.

import { Logger, NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import { dedup, meshopt, prune, resample, simplify, weld } from "@gltf-transform/functions";
import { MeshoptDecoder } from "meshoptimizer/decoder";
import { MeshoptEncoder } from "meshoptimizer/encoder";
import { MeshoptSimplifier } from "meshoptimizer/simplifier";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";

const [source, folder, part] = process.argv.slice(2);
if (!folder) {
  console.error("usage: node files.mjs SOURCE FOLDER [PART]");
  process.exit(2);
}

const GLTFPACK = join(dirname(createRequire(import.meta.url).resolve("gltfpack")), "cli.js");

/** Settings of gltfpack: its defaults at two strengths, and with all that keeps motion and names. */
const SETTINGS = [
  "-c",
  "-cz",
  "-cz -af 0",
  "-cc -af 0 -kn -km -ke -ar 14",
  "-cz -af 0 -kn -km -ke -ar 14",
].map((setting) => (part ? `${setting} -si ${part}` : setting));

function gltfpack(setting) {
  const file = join(folder, `gltfpack${setting.replaceAll(" ", "")}.glb`);
  const words = [GLTFPACK, "-i", source, "-o", file, ...setting.split(" ")];
  execFileSync(process.execPath, words, { stdio: "pipe" });
  return file;
}

/** What `gltf-transform optimize` does, without pictures and joined nodes. */
async function gltfTransform(setting) {
  await Promise.all([MeshoptDecoder.ready, MeshoptEncoder.ready, MeshoptSimplifier.ready]);
  const io = new NodeIO().registerExtensions(ALL_EXTENSIONS);
  io.registerDependencies({ "meshopt.decoder": MeshoptDecoder, "meshopt.encoder": MeshoptEncoder });
  const document = (await io.read(source)).setLogger(new Logger(Logger.Verbosity.ERROR));
  const keys = setting.includes("resample") ? [resample()] : [];
  const level = meshopt({ encoder: MeshoptEncoder, level: "high" });
  // The error is free, as that of gltfpack is, so that the part is reached.
  const fewer = part ? [simplify({ simplifier: MeshoptSimplifier, ratio: Number(part), error: 1 })] : [];
  await document.transform(dedup(), ...keys, prune(), weld(), ...fewer, level);
  const file = join(folder, `gltf-transform-${setting.replaceAll(" ", "-")}.glb`);
  await io.write(file, document);
  return file;
}

const CONTESTANTS = [
  ...SETTINGS.map((setting) => ({ peer: "gltfpack", setting, write: gltfpack })),
  ...["meshopt", "resample meshopt"]
    .map((setting) => (part ? `simplify ${part} ${setting}` : setting))
    .map((setting) => ({ peer: "glTF-Transform", setting, write: gltfTransform })),
];
const found = [];
for (const { peer, setting, write } of CONTESTANTS) {
  try {
    const file = await write(setting);
    found.push({ peer, setting, file: existsSync(file) ? file : null, fault: null });
  } catch (error) {
    found.push({ peer, setting, file: null, fault: String(error.message ?? error).split("\n")[0] });
  }
}
console.log(JSON.stringify(found));
