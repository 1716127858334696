// What figures, crowds and the loader do beside being drawn.
import { ArticulaCrowd, ArticulaError, ArticulaFigure, ArticulaLoader } from '@articula/three';
import { Articula } from '@articula/core';
import * as THREE from 'three';

import { madeCharacter } from './made.js';
import { compare, draw, makeStage } from './stage.js';
import { theirs } from './theirs.js';

const PAB = '/assets/glb/pab_arnaud.glb';

async function opened(source) {
  const loader = new ArticulaLoader();
  loader.prepare = false;
  return loader.loadAsync(source);
}

/** How far a socket is from three.js's bone, in metres, for a figure that was moved and turned. */
export async function socketDistance(joint) {
  const [asset, makeTheirs] = await Promise.all([opened(PAB), theirs(PAB)]);
  const figure = new ArticulaFigure(asset);
  const held = new THREE.Object3D();
  held.position.set(0.1, 0.2, 0.3);
  figure.socket(joint).add(held);
  figure.position.set(3, 1, -2);
  figure.rotation.y = 1;
  figure.play('walk', 0.3).update(0.2);
  const their = makeTheirs('walk', 0.5);
  their.position.copy(figure.position);
  their.rotation.copy(figure.rotation);
  const expected = new THREE.Object3D();
  expected.position.copy(held.position);
  their.getObjectByName(joint).add(expected);
  const [a, b] = [held, expected].map((object) => object.getWorldPosition(new THREE.Vector3()));
  figure.dispose();
  asset.dispose();
  return a.distanceTo(b);
}

/** Metres between feet of figures that should stand alike, and the angle of a head that was turned by 90 degrees. */
export async function motions() {
  const asset = await opened(PAB);
  const make = () => new ArticulaFigure(asset);
  const foot = (figure) => figure.socket('LeftFoot').position.clone();
  const head = (figure) => figure.socket('Head').quaternion.clone();
  const camera = new THREE.PerspectiveCamera();
  camera.position.z = 60;
  const [plain, faded, layered, turned, far] = Array.from({ length: 5 }, make);
  [plain, turned, far].forEach((figure) => figure.play('run', 0.1).update(0.3));
  faded.play('walk').fadeTo('run', 0.1).update(0.2);
  faded.update(0.2);
  const all = layered.play('walk').addLayer('run', { weight: 0 });
  layered.setLayerWeight(all, 1).update(0.4);
  const half = Math.SQRT1_2;
  turned.poseJoint('Head', new THREE.Quaternion(0, half, 0, half)).update(0);
  const angle = head(turned).angleTo(head(plain));
  turned.clearPosed().update(0);
  far.setTolerance(1).update(0, camera, { width: 320, height: 240 });
  const stands = { faded, layered, far, turned };
  const apart = Object.fromEntries(
    Object.entries(stands).map(([name, figure]) => [name, foot(figure).distanceTo(foot(plain))]),
  );
  const returned = head(turned).angleTo(head(plain));
  [plain, faded, layered, turned, far].forEach((figure) => figure.dispose());
  asset.dispose();
  return { apart, angle, returned };
}

/** Which characters rays hit that are cast at the place of each, in a crowd that was moved; and at nobody. */
export async function hits() {
  const asset = await opened(PAB);
  const crowd = new ArticulaCrowd(asset, 5, { clips: ['walk'] });
  crowd.position.set(10, 0, 3);
  crowd.rotation.y = 0.7;
  crowd.scale.setScalar(2);
  for (let i = 0; i < crowd.count; i += 1) {
    crowd.place(i, 2 * i, 0, 0);
  }
  crowd.updateMatrixWorld(true);
  crowd.update(0, new THREE.PerspectiveCamera(), { width: 100, height: 100 });
  const cast = (x) => {
    const target = crowd.localToWorld(new THREE.Vector3(x, 1, 0));
    const origin = crowd.localToWorld(new THREE.Vector3(x, 1, 30));
    const hit = new THREE.Raycaster(origin, target.clone().sub(origin).normalize()).intersectObject(crowd)[0];
    return hit && { character: hit.instanceId, off: Math.abs(hit.point.distanceTo(target)) };
  };
  const found = [0, 1, 2, 3, 4].map((i) => cast(2 * i));
  const missed = cast(-9) === undefined;
  const figure = new ArticulaFigure(asset);
  figure.position.x = 40;
  figure.updateMatrixWorld(true);
  const ray = new THREE.Raycaster(new THREE.Vector3(40, 1.2, 10), new THREE.Vector3(0, 0, -1));
  const onFigure = ray.intersectObject(figure)[0]?.point.z;
  crowd.dispose();
  figure.dispose();
  asset.dispose();
  return { found, missed, onFigure };
}

/** The tolerance of a crowd that has no time, and of two cameras of which one sees it. */
export async function budgetAndViews() {
  const asset = await opened(PAB);
  const crowd = new ArticulaCrowd(asset, 200, { clips: ['walk'], poseCache: false });
  for (let i = 0; i < crowd.count; i += 1) {
    crowd.place(i, i % 20, 0, -Math.floor(i / 20)).play(i, 'walk', 0.1 * i);
  }
  const [near, away] = [new THREE.PerspectiveCamera(), new THREE.PerspectiveCamera()];
  near.position.set(10, 1, 10);
  away.position.set(10, 1, 10);
  away.rotation.y = Math.PI;
  const size = { width: 800, height: 600 };
  const seenBy = (cameras) => {
    crowd.update(0, cameras, size);
    return crowd.core.draws;
  };
  const seen = { none: seenBy(away), both: seenBy([away, near]), one: seenBy(near) };
  crowd.setBudget(1e-4);
  for (let frame = 0; frame < 40; frame += 1) {
    crowd.update(1 / 60, near, size);
  }
  const tolerance = crowd.core.tolerancePx;
  crowd.dispose();
  asset.dispose();
  return { seen, tolerance };
}

/** The errors of files that are none, and whether another opens after them. */
export async function hostile() {
  const errors = [];
  const truncated = (await (await fetch(PAB)).arrayBuffer()).slice(0, 5000);
  for (const bytes of [new Uint8Array(0), new Uint8Array(1000).fill(7), new Uint8Array(truncated)]) {
    const error = await opened(new File([bytes], 'bad.glb')).catch((reason) => reason);
    errors.push({ own: error instanceof ArticulaError, code: error.code, file: error.file, message: error.message });
  }
  const asset = await opened(new Blob([await madeCharacter()]));
  const { clips } = asset;
  const clip = await Promise.resolve()
    .then(() => new ArticulaFigure(asset).play('no such'))
    .catch((reason) => reason.message);
  asset.dispose();
  return { errors, clips, clip };
}

/** Loads for one that is drawn: its shaders are compiled anew, which takes a second. */
const LOADS_A_PICTURE = 10;

/** Bytes of the module and objects of the renderer after loads and disposals, of the first and the last half. */
export async function disposals(renderer, times) {
  const file = await madeCharacter();
  const { memory } = await Articula.load();
  const { scene, camera } = makeStage(1, 2);
  const sizes = [];
  for (let i = 0; i < times; i += 1) {
    const asset = await opened(new Blob([file]));
    const figure = new ArticulaFigure(asset);
    const crowd = new ArticulaCrowd(asset, 4);
    crowd.update(0.1, camera, renderer);
    scene.add(figure, crowd);
    const isDrawn = i % LOADS_A_PICTURE === LOADS_A_PICTURE - 1;
    if (isDrawn) {
      draw(renderer, scene, camera);
    }
    figure.dispose();
    crowd.dispose();
    asset.dispose();
    if (isDrawn) {
      draw(renderer, scene, camera);
    }
    const { geometries, textures } = renderer.info.memory;
    sizes.push({ bytes: memory.buffer.byteLength, geometries, textures, programs: renderer.info.programs.length });
  }
  return { half: sizes[times / 2 - 1], last: sizes[times - 1] };
}

/** A crowd before and after the context was lost and came back. */
export async function contextLoss(renderer) {
  const asset = await opened(PAB);
  const { scene, camera } = makeStage(1.8, 2);
  const crowd = new ArticulaCrowd(asset, 4, { clips: ['walk'] });
  const figure = new ArticulaFigure(asset);
  for (let i = 0; i < crowd.count; i += 1) {
    crowd.place(i, 1.5 * i - 2, 0, -1).setColorAt(i, new THREE.Color().setHSL(i / 4, 1, 0.5));
  }
  crowd.update(0.3, camera, renderer);
  scene.add(crowd, figure);
  const before = draw(renderer, scene, camera);
  const canvas = renderer.domElement;
  const event = (name) => new Promise((resolve) => canvas.addEventListener(name, resolve, { once: true }));
  const lost = event('webglcontextlost');
  renderer.forceContextLoss();
  await lost;
  // The context can be given back once the event was handled.
  await new Promise((resolve) => setTimeout(resolve, 0));
  const restored = event('webglcontextrestored');
  renderer.forceContextRestore();
  await restored;
  const after = draw(renderer, scene, camera);
  const colors = crowdColors(before);
  crowd.dispose();
  figure.dispose();
  asset.dispose();
  return { ...(await compare(before, after)), colors };
}

/** How many of four strong hues a picture has. */
function crowdColors({ data }) {
  const hues = new Set();
  const color = new THREE.Color();
  for (let at = 0; at < data.length; at += 4) {
    const hsl = color.setRGB(data[at] / 255, data[at + 1] / 255, data[at + 2] / 255).getHSL({});
    if (hsl.s > 0.6) {
      hues.add(Math.round(hsl.h * 4) % 4);
    }
  }
  return hues.size;
}

/** An expression and a morph target of a face. */
export async function faces() {
  const asset = await opened('/assets/glb/ict_head_talk_554.glb');
  const figure = new ArticulaFigure(asset);
  const at = (name) => figure.mesh.morphTargetInfluences[figure.mesh.morphTargetDictionary[name]];
  figure.update(0);
  const rest = at('jawOpen');
  const known = figure.setExpression('jawOpen', 1);
  figure.setMorph('browDown_L', 0.25).update(0);
  const set = [at('jawOpen') - rest, at('browDown_L')];
  figure.clearMorphs().update(0);
  const cleared = at('jawOpen') - rest;
  const unknown = figure.setExpression('no such', 1);
  figure.dispose();
  asset.dispose();
  return { known, unknown, set, cleared };
}

/** Opens a motion of another format. */
export async function otherFormat() {
  const asset = await new ArticulaLoader().loadAsync('/assets/bvh/makehuman_walk1.bvh');
  const facts = { clips: asset.clips.length, joints: asset.joints.length };
  asset.dispose();
  return facts;
}

/** Prepares in a worker, and ends preparing. */
export async function preparing() {
  const file = new File([await madeCharacter()], 'made.glb');
  const loader = new ArticulaLoader();
  const abort = new AbortController();
  loader.signal = abort.signal;
  loader.onPrepare = () => abort.abort();
  const cancelled = await loader.loadAsync(file).catch((error) => error);
  loader.signal = undefined;
  let steps = 0;
  loader.onPrepare = () => {
    steps += 1;
  };
  const asset = await loader.loadAsync(file);
  const facts = { prepared: asset.core.isPrepared, warnings: asset.warnings, clips: asset.clips };
  asset.dispose();
  return { cancelled: cancelled.code, steps, ...facts };
}

/** Events that a figure and a crowd tell in two thirds of a clip that begins at a third. */
export async function clipEvents() {
  const asset = await opened(new Blob([await madeCharacter()]));
  const clip = asset.clips[0];
  const secs = asset.clipSecs[0];
  const events = { [clip]: [0.1, 0.5, 0.9].map((share, i) => ({ secs: share * secs, id: 10 + i })) };
  const told = [];
  const hear = (object) => object.addEventListener('clipevent', ({ character, clip, id }) => told.push([character, clip, id]));
  const figure = new ArticulaFigure(asset, { events });
  hear(figure);
  figure.play(clip, secs / 3).update(secs / 3);
  figure.update(secs / 3);
  const crowd = new ArticulaCrowd(asset, 2, { events });
  hear(crowd);
  crowd.play(0, clip, 0.4 * secs).play(1, clip, 0.8 * secs);
  // The camera looks away: events are told nevertheless.
  const camera = new THREE.PerspectiveCamera();
  camera.position.z = -50;
  crowd.update(0.2 * secs, camera, { width: 100, height: 100 });
  const unknown = await Promise.resolve()
    .then(() => new ArticulaCrowd(asset, 1, { events: { fly: [{ secs: 0, id: 1 }] } }))
    .catch((error) => error);
  figure.dispose();
  crowd.dispose();
  asset.dispose();
  return { clip, told, code: unknown.code, message: unknown.message };
}

/** Levels of three characters beside each other, by their roles. */
export async function roles() {
  const asset = await opened(PAB);
  const crowd = new ArticulaCrowd(asset, 3, { clips: ['walk'], poseCache: false });
  const names = ['main', 'secondary', 'audience'];
  names.forEach((name, i) => crowd.place(i, 0.1 * (i - 1), 0, 0).play(i, 'walk', 0.3).setRoleAt(i, name));
  const camera = new THREE.PerspectiveCamera();
  const size = { width: 800, height: 600 };
  const levels = () => {
    crowd.update(0, camera, size);
    return names.map((_, i) => crowd.levelOf(i));
  };
  // From where an eighth of the error makes two levels of difference.
  let first = [];
  for (let metres = 4; metres < 100 && new Set(first).size < names.length; metres *= 1.1) {
    camera.position.set(0, 1, metres);
    first = levels();
  }
  const [, , raised] = (crowd.setRole('audience', 4), levels());
  const [, own] = (crowd.setImportance(1, 16), levels());
  const [, left] = (crowd.setImportance(1, 1).setRoleAt(1, undefined), levels());
  let unknown = '';
  try {
    crowd.setRoleAt(0, 'king');
  } catch (error) {
    unknown = String(error);
  }
  crowd.dispose();
  asset.dispose();
  return { levels: first, raised, own, left, unknown };
}
