// The example for Babylon.js beside three.js's own: the same outlines.
import { Articula } from '@articula/core';
import { FreeCamera } from '@babylonjs/core/Cameras/freeCamera.js';
import { Engine } from '@babylonjs/core/Engines/engine.js';
import { Color4 } from '@babylonjs/core/Maths/math.color.js';
import { Vector3 } from '@babylonjs/core/Maths/math.vector.js';
import { Scene } from '@babylonjs/core/scene.js';
import * as THREE from 'three';

import { BabylonCrowd } from '../../examples/babylon.js';
import { compare, draw, HEIGHT, shown, WIDTH } from './stage.js';
import { theirs } from './theirs.js';

const PLACES = Array.from({ length: 9 }, (_, i) => ({
  x: 1.6 * ((i % 3) - 1),
  z: 1.6 * (Math.floor(i / 3) - 1),
  yaw: 0.5 * i,
  secs: 0.11 * i,
}));
const FOV = 0.7;
const EYE = [2.5, 3, 6];

/** Outlines of nine characters by three.js and by Babylon.js. */
export async function babylonPicture(renderer, url, clip) {
  const reference = await threePicture(renderer, await theirs(url), clip);
  const ours = await crowdPicture(url, clip);
  const empty = new ImageData(WIDTH, HEIGHT);
  return { ...(await compare(reference, outlines(ours))), shown: shown(empty, outlines(ours)) };
}

async function threePicture(renderer, make, clip) {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0);
  scene.overrideMaterial = new THREE.MeshBasicMaterial();
  for (const { x, z, yaw, secs } of PLACES) {
    const figure = make(clip, secs);
    figure.position.set(x, 0, z);
    figure.rotation.y = yaw;
    scene.add(figure);
  }
  const camera = new THREE.PerspectiveCamera(THREE.MathUtils.radToDeg(FOV), WIDTH / HEIGHT, 0.1, 50);
  camera.position.set(...EYE);
  camera.lookAt(0, 1, 0);
  return outlines(draw(renderer, scene, camera));
}

async function crowdPicture(url, clip) {
  const canvas = document.createElement('canvas');
  canvas.width = WIDTH;
  canvas.height = HEIGHT;
  document.body.append(canvas);
  const engine = new Engine(canvas, false, { preserveDrawingBuffer: true });
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  scene.clearColor = new Color4(0, 0, 0, 1);
  const camera = new FreeCamera('camera', new Vector3(...EYE), scene);
  camera.fov = FOV;
  camera.minZ = 0.1;
  camera.maxZ = 50;
  camera.setTarget(new Vector3(0, 1, 0));
  const articula = await Articula.load();
  const asset = articula.open(new Uint8Array(await (await fetch(url)).arrayBuffer()), 'character.glb');
  const crowd = new BabylonCrowd(scene, articula, asset, PLACES.length, { rootMotion: 'as-authored', meshLevels: 1 });
  crowd.crowd.setFull();
  PLACES.forEach(({ x, z, yaw, secs }, i) => {
    crowd.crowd.place(i, x, 0, z, yaw);
    crowd.crowd.play(i, asset.clips.indexOf(clip), secs);
  });
  crowd.update(0, camera, WIDTH, HEIGHT);
  await scene.whenReadyAsync();
  scene.render();
  const copy = new OffscreenCanvas(WIDTH, HEIGHT).getContext('2d');
  copy.drawImage(canvas, 0, 0);
  const picture = copy.getImageData(0, 0, WIDTH, HEIGHT);
  crowd.dispose();
  asset.free();
  engine.dispose();
  return picture;
}

/** White where something is drawn. */
function outlines({ data }) {
  const picture = new ImageData(WIDTH, HEIGHT);
  for (let at = 0; at < data.length; at += 4) {
    picture.data.fill(data[at] + data[at + 1] + data[at + 2] > 30 ? 255 : 0, at, at + 3);
    picture.data[at + 3] = 255;
  }
  return picture;
}
