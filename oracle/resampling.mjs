// How far written motions are from their source, judged by three.js: `node resampling.mjs PROGRAM
// FILE[#CLIP]...`. PROGRAM is the articula program, FILE a GLB, VRM or VRMA; without CLIP all clips of the
// file. Each clip is written in the format of FILE, as an asset (`build`, but for VRMA), as motion streams of 0.1
// and 1 mm, which are decoded onto FILE, and as BVH; source and result are played at seeded random times. Prints
// one JSON row for each of them, {file, clip, way, max_mm, secs, bound_mm}, and a table on standard error. Ends with
// status 1 if a bound is exceeded.
//
// All files of a folder: `node resampling.mjs ../target/release/articula FOLDER/*.glb FOLDER/*.vrma`.

import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, extname, join } from "node:path";
import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { random } from "./random.mjs";
import { openScene } from "./scene.mjs";

const { BVHLoader } = await import("three/addons/loaders/BVHLoader.js");

const RANDOM_TIMES = 24;
const MOST_VERTICES = 1500;

/** Resampling within 0.1 mm, the stated tolerance, and for regular keys that turn fast what blends lag. */
const RESAMPLING_MM = 0.1;
/** A BVH file rounds centimetres and degrees to some decimals, which add up along an arm. */
const BVH_MM = 0.2;

/** Parts of a prepared asset that show no clip by themselves. */
const NOT_CLIPS =
  "joint-levels,skins,bounds,paired-levels,pose-cache,joint-keys,pose-keys,error-matrix,contacts,compact-clips";

/** Plays a clip below a root from its beginning to each time and calls `show`. */
function play(root, clip, times, show) {
  const mixer = new AnimationMixer(root);
  const action = mixer.clipAction(clip);
  action.setLoop(LoopOnce, 1);
  action.clampWhenFinished = true;
  return times.map((time) => {
    action.reset().play();
    mixer.update(time);
    root.updateMatrixWorld(true);
    return show();
  });
}

/** Names of nodes whose channels drive expressions and the gaze (VRMC_vrm_animation), not joints. */
function notJoints({ parser: { json } }) {
  const { expressions, lookAt } = json.extensions?.VRMC_vrm_animation ?? {};
  const kinds = [expressions?.preset, expressions?.custom].flatMap((kind) => Object.values(kind ?? {}));
  const nodes = [...kinds, lookAt].map((one) => json.nodes[one?.node]?.name);
  return new Set(nodes.filter((name) => name !== undefined));
}

/** World positions of at most so many vertices, spread evenly; of all joints where there is no mesh. Flat. */
function skin({ scene, others }) {
  const meshes = [];
  scene.traverse((object) => object.isMesh && meshes.push(object));
  if (meshes.length === 0) {
    const nodes = [];
    scene.traverse((object) => object !== scene && !others.has(object.name) && nodes.push(object));
    return () => nodes.map((node) => new Vector3().setFromMatrixPosition(node.matrixWorld));
  }
  const count = meshes.reduce((sum, mesh) => sum + mesh.geometry.attributes.position.count, 0);
  const step = Math.max(1, Math.ceil(count / MOST_VERTICES));
  return () => {
    const at = new Vector3();
    const all = [];
    for (const mesh of meshes) {
      for (let i = 0; i < mesh.geometry.attributes.position.count; i += step) {
        all.push(mesh.getVertexPosition(i, at).applyMatrix4(mesh.matrixWorld).clone());
      }
    }
    return all;
  };
}

/** World positions of named nodes, in metres. */
function joints(find, names, metres) {
  return () => names.map((name) => new Vector3().setFromMatrixPosition(find(name).matrixWorld).multiplyScalar(metres));
}

/** The greatest distance of two lists of positions over the times. */
function farthest(times, wanted, shown) {
  let worst = { max_mm: 0, secs: 0 };
  times.forEach((secs, i) => {
    wanted[i].forEach((at, k) => {
      const max_mm = 1e3 * at.distanceTo(shown[i][k]);
      // A distance that is no number counts as one, too.
      if (!(max_mm <= worst.max_mm)) worst = { max_mm, secs };
    });
  });
  return worst;
}

/** The scene of a GLB and its clip of a name, or the only one. */
async function opened(file, name) {
  const { gltf } = await openScene(file);
  const clip = gltf.animations.find((one) => one.name === name) ?? gltf.animations[0];
  return { scene: gltf.scene, clip, others: notJoints(gltf) };
}

function bvh(file) {
  const text = readFileSync(file, "utf8");
  const { skeleton, clip } = new BVHLoader().parse(text);
  const channels = text.matchAll(/(?:ROOT|JOINT) (.+)\n\s*\{\n\s*OFFSET.*\n\s*CHANNELS \d+ Xposition/g);
  const moved = new Set(Array.from(channels, (found) => `${found[1].trim()}.position`));
  // The loader adds offsets to position channels, which in this format take their place.
  for (const track of clip.tracks.filter((one) => moved.has(one.name))) {
    const bone = skeleton.bones.find((one) => `${one.name}.position` === track.name);
    track.values = track.values.map((value, i) => value - bone.position.getComponent(i % 3));
  }
  return { skeleton, clip };
}

const [program, ...asked] = process.argv.slice(2);
if (!program || asked.length === 0) {
  console.error("usage: node resampling.mjs PROGRAM FILE[#CLIP]...");
  process.exit(2);
}
const folder = mkdtempSync(join(tmpdir(), "articula-resampling-"));
let isWithin = true;

function articula(...words) {
  const { status, stdout, stderr } = spawnSync(program, [...words, "--force", "--json"], { encoding: "utf8" });
  if (status !== 0) throw new Error(`${words.join(" ")}: ${stderr}`);
  return JSON.parse(stdout);
}

function told(file, clip, way, { max_mm, secs }, bound_mm) {
  isWithin &&= max_mm <= bound_mm;
  console.log(JSON.stringify({ file: basename(file), clip, way, max_mm, secs, bound_mm }));
  const row = [basename(file).padEnd(36), clip.padEnd(32), way.padEnd(10), max_mm.toFixed(4).padStart(10), bound_mm];
  console.error(row.join(" "));
}

async function judge(file, asset, index, measured) {
  const name = measured.name;
  const source = await opened(file, name);
  const seeded = random(1000 + index);
  const times = Array.from({ length: RANDOM_TIMES }, () => seeded() * source.clip.duration);
  const wanted = play(source.scene, source.clip, times, skin(source));
  // What frames of regular keys miss is stated; everything else stays within the bound.
  const resampling_mm = Math.max(RESAMPLING_MM, measured.resampling_mm);
  const ending = extname(file);
  const same = join(folder, `clip${ending}`);
  const stream = join(folder, "clip.abp");
  const shown = join(folder, "shown.glb");
  const streamed = (tolerance) => () => {
    articula("convert", file, stream, "--clip", name, "--stream", `tolerance-mm=${tolerance}`);
    articula("convert", stream, shown, "--onto", file);
    return shown;
  };
  const ways = [
    [ending.slice(1), () => (articula("convert", file, same, "--clip", name), same), 0.01],
    ["abp 0.1", streamed("0.1"), 0.1 + resampling_mm],
    ["abp 1", streamed("1"), 1 + resampling_mm],
  ];
  if (asset) ways.push(["build", () => asset, 0.01]);
  for (const [way, write, bound_mm] of ways) {
    const result = await opened(write(), name);
    const positions = play(result.scene, result.clip, times, skin(result));
    told(file, name, way, farthest(times, wanted, positions), bound_mm);
  }
  const written = join(folder, "clip.bvh");
  articula("convert", file, written, "--clip", name);
  const { skeleton, clip } = bvh(written);
  const bone = (joint) => skeleton.bones.find((one) => one.name === joint);
  const find = (joint) => source.scene.getObjectByName(joint);
  // Joints that got standard names may have those of other joints of the file; their parents differ.
  const isKnown = ({ name, parent }) => find(name) && (!parent?.isBone || find(name).parent.name === parent.name);
  const known = skeleton.bones.filter((one) => one.name !== "ENDSITE" && isKnown(one)).map((one) => one.name);
  const there = play(source.scene, source.clip, times, joints(find, known, 1));
  const here = play(skeleton.bones[0], clip, times, joints(bone, known, 0.01));
  told(file, name, "bvh", farthest(times, there, here), RESAMPLING_MM + BVH_MM);
}

try {
  for (const word of asked) {
    const [file, name] = word.split("#");
    const clips = articula("inspect", file).clips;
    const chosen = name === undefined ? clips : clips.filter((clip) => clip.name === name);
    if (chosen.length === 0) throw new Error(`${file} has no clip ${name}`);
    const asset = extname(file) === ".vrma" ? undefined : join(folder, "asset.glb");
    if (asset) articula("build", file, asset, "--levels", "1", "--without", NOT_CLIPS);
    for (const [index, clip] of chosen.entries()) await judge(file, asset, index, clip);
  }
} finally {
  rmSync(folder, { recursive: true });
}
process.exit(isWithin ? 0 : 1);
