// What the benchmark calls in the page.
import { Articula } from '@articula/core';
import { ArticulaLoader } from '@articula/three';
import * as THREE from 'three';

import { bakedAnimation, bakedPictures } from './babylon.js';
import { bytesOf, KINDS, makeCrowd } from './ours.js';
import { character, makeCamera, VIEW } from './scene.js';
import { BAKED_HZ, bakedRecords, instancedMesh, loadTheirs, mixers, posedMixers } from './theirs.js';

const DT = 1 / 60;
/** A run lasts at least this long, since clocks of browsers are coarse. */
const RUN_MS = 60;
const RUNS = 5;
/** Levels by which a pixel may differ. */
const SAME = 8;
const PICTURE = { width: 640, height: 360 };
const PICTURE_COUNT = 64;
const PICTURE_SECS = 0.3;
const BABYLON = 'Babylon.js, baked vertex animation';

/** Median and least milliseconds of a frame, over runs of many frames. */
function timed(frame) {
  for (let i = 0; i < 3; i += 1) {
    frame();
  }
  const runs = Array.from({ length: RUNS }, () => {
    const start = performance.now();
    let frames = 0;
    do {
      frame();
      frames += 1;
    } while (performance.now() - start < RUN_MS);
    return (performance.now() - start) / frames;
  });
  runs.sort((a, b) => a - b);
  return { median: runs[RUNS >> 1], least: runs[0] };
}

function timeTheirs(make, loaded, count) {
  const made = make(loaded, count);
  const ms = timed(() => made.frame(DT));
  const bytes = made.bytes();
  made.dispose();
  return { ...ms, bytes };
}

function timeOurs(asset, clip, count, kind) {
  const crowd = makeCrowd(asset, clip, count, kind, 'in-place');
  const camera = makeCamera();
  const ms = timed(() => crowd.update(DT, camera, VIEW));
  const { core } = crowd;
  const seen = core.draws + core.records + core.stepped;
  const bytes = bytesOf(crowd);
  crowd.dispose();
  return { ...ms, bytes, seen };
}

/** Milliseconds until a crowd of ten has its first frame. */
function firstFrame(asset, clip, poseCache) {
  const start = performance.now();
  const crowd = makeCrowd(asset, clip, 10, '1 px, blended by the CPU', 'in-place', poseCache);
  crowd.update(DT, makeCamera(), VIEW);
  const ms = performance.now() - start;
  crowd.dispose();
  return ms;
}

function stage() {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x8899aa);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x556655, 2));
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(1, 2, 1.5);
  scene.add(sun);
  return scene;
}

function pixels(renderer, object) {
  const scene = stage();
  scene.add(object);
  renderer.render(scene, makeCamera(PICTURE));
  const canvas = new OffscreenCanvas(PICTURE.width, PICTURE.height);
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(renderer.domElement, 0, 0);
  return context.getImageData(0, 0, PICTURE.width, PICTURE.height).data;
}

/** Percent of the pixels that show a figure in either picture and differ by more than a few levels. */
function difference(a, b, empty) {
  let figure = 0;
  let off = 0;
  const differ = (p, q, at) => [0, 1, 2].some((i) => Math.abs(p[at + i] - q[at + i]) > SAME);
  for (let at = 0; at < a.length; at += 4) {
    if (differ(a, empty, at) || differ(b, empty, at)) {
      figure += 1;
      off += differ(a, b, at) ? 1 : 0;
    }
  }
  return { percent: (100 * off) / Math.max(1, figure), figure };
}

/** Pictures of each contender beside exact poses of three.js itself. */
async function pictures(asset, loaded, clip) {
  const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  renderer.setPixelRatio(1);
  renderer.setSize(PICTURE.width, PICTURE.height);
  const empty = pixels(renderer, new THREE.Group());
  const exact = pixels(renderer, posedMixers(loaded, PICTURE_COUNT, PICTURE_SECS));
  const held = pixels(renderer, posedMixers(loaded, PICTURE_COUNT, PICTURE_SECS, BAKED_HZ));
  const errors = { 'baked texture of poses': difference(exact, held, empty) };
  for (const kind of Object.keys(KINDS)) {
    const crowd = makeCrowd(asset, clip, PICTURE_COUNT, kind, 'as-authored');
    for (let i = 0; i < PICTURE_COUNT; i += 1) {
      crowd.play(i, clip, (character(i, PICTURE_COUNT).secs + PICTURE_SECS) % loaded.animation.duration);
    }
    crowd.update(0, makeCamera(PICTURE), PICTURE);
    errors[kind] = difference(exact, pixels(renderer, crowd), empty);
    crowd.dispose();
  }
  renderer.dispose();
  const baked = await bakedPictures(loaded, PICTURE_COUNT, PICTURE_SECS, PICTURE);
  errors[BABYLON] = difference(baked.exact, baked.held, baked.empty);
  return errors;
}

window.bench = {
  /** Measures one file, whose first clip of a walk is played. */
  async file(url, counts) {
    const started = performance.now();
    await Articula.load();
    const start = performance.now();
    const asset = await new ArticulaLoader().loadAsync(url);
    const [moduleMs, openMs] = [start - started, performance.now() - start];
    const clip = asset.clips.find((name) => /walk/i.test(name)) ?? asset.clips[0];
    const firstMs = [false, true].map((poseCache) => firstFrame(asset, clip, poseCache));
    const loaded = await loadTheirs(url, clip);
    const rows = [];
    for (const count of counts) {
      const theirs = [
        ['SkinnedMesh, a mixer each', mixers],
        ['instanced-mesh, one mixer', instancedMesh],
        ['baked texture of poses', bakedRecords],
        [BABYLON, bakedAnimation],
      ];
      for (const [name, make] of theirs) {
        rows.push({ count, name, ...timeTheirs(make, loaded, count) });
      }
      for (const kind of Object.keys(KINDS)) {
        rows.push({ count, name: `Articula, ${kind}`, ...timeOurs(asset, clip, count, kind) });
      }
    }
    const errors = await pictures(asset, loaded, clip);
    return { clip, moduleMs, openMs, firstMs, rows, errors, joints: asset.core.joints.length, warnings: asset.core.warnings };
  },
};
