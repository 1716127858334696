// A renderer with lights of two kinds, fog, a floor with shadows, and the pixels of what it draws.
import * as THREE from 'three';

export const WIDTH = 320;
export const HEIGHT = 240;

/** Makes a renderer: `webgl`, `webgpu`, or `webgpu-webgl` for WebGL 2 by the renderer of WebGPU. */
export async function makeRenderer(kind) {
  let renderer;
  if (kind === 'webgl') {
    renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  } else {
    const { WebGPURenderer } = await import('three/webgpu');
    renderer = new WebGPURenderer({ antialias: false, forceWebGL: kind === 'webgpu-webgl' });
    await renderer.init();
    const isWebGPU = renderer.backend.isWebGPUBackend === true;
    if (isWebGPU !== (kind === 'webgpu')) {
      throw new Error(`asked for ${kind}, the renderer has ${isWebGPU ? 'WebGPU' : 'WebGL'}`);
    }
  }
  renderer.setPixelRatio(1);
  renderer.setSize(WIDTH, HEIGHT);
  renderer.shadowMap.enabled = true;
  document.body.append(renderer.domElement);
  return renderer;
}

/** A scene, with a lamp or by sun alone, around characters of a height, and a camera that sees `columns` of them. */
export function makeStage(height, columns, hasLamp = false) {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x8899aa);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x556655, 1));
  const sun = new THREE.DirectionalLight(0xffffff, 2.5);
  sun.position.set(1, 2, 1.5).multiplyScalar(2 * height);
  sun.castShadow = true;
  const reach = columns * height;
  Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, far: 10 * height });
  sun.shadow.bias = -0.002;
  scene.add(sun);
  scene.fog = new THREE.Fog(0x8899aa, 2 * height, 25 * height);
  if (hasLamp) {
    const lamp = new THREE.PointLight(0xffeecc, 4 * height * height);
    lamp.position.set(-0.8, 1.3, 0.9).multiplyScalar(height);
    lamp.castShadow = true;
    lamp.shadow.mapSize.setScalar(256);
    lamp.shadow.bias = -0.004;
    scene.add(lamp);
  }
  const ground = new THREE.MeshStandardMaterial({ color: 0x555b55 });
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(40 * height, 40 * height), ground);
  floor.rotation.x = -Math.PI / 2;
  floor.receiveShadow = true;
  scene.add(floor);
  const camera = new THREE.PerspectiveCamera(40, WIDTH / HEIGHT, height / 50, 50 * height);
  camera.position.set(0.5, 0.9, 1).multiplyScalar((0.6 + 0.75 * columns) * height);
  camera.lookAt(0, 0.45 * height, 0);
  return { scene, camera };
}

/** Draws, and returns the pixels. */
export function draw(renderer, scene, camera) {
  // WebGPURenderer draws shadow maps once in a frame of the page.
  renderer._nodes?.nodeFrame.update();
  renderer.render(scene, camera);
  const canvas = new OffscreenCanvas(WIDTH, HEIGHT);
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(renderer.domElement, 0, 0);
  return context.getImageData(0, 0, WIDTH, HEIGHT);
}

/** Levels by which two pixels may differ. */
const SAME = 8;

/** Compares pictures: the percentage of pixels that differ, and all three side by side. */
export async function compare(theirs, ours) {
  const diff = new ImageData(WIDTH, HEIGHT);
  let different = 0;
  for (let at = 0; at < diff.data.length; at += 4) {
    const off = Math.max(...[0, 1, 2].map((i) => Math.abs(theirs.data[at + i] - ours.data[at + i])));
    different += off > SAME ? 1 : 0;
    diff.data.fill(off > SAME ? 255 : 0, at, at + 3);
    diff.data[at + 3] = 255;
  }
  const canvas = new OffscreenCanvas(WIDTH * 3, HEIGHT);
  const context = canvas.getContext('2d');
  [theirs, ours, diff].forEach((picture, i) => context.putImageData(picture, i * WIDTH, 0));
  const png = new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer());
  return { percent: (100 * different) / (WIDTH * HEIGHT), png: png.toBase64?.() ?? btoa(String.fromCharCode(...png)) };
}

/** Share of pixels that are not the background, in percent: a picture of nothing proves nothing. */
export function shown(before, after) {
  let changed = 0;
  for (let at = 0; at < before.data.length; at += 4) {
    const off = [0, 1, 2].some((i) => Math.abs(before.data[at + i] - after.data[at + i]) > SAME);
    changed += off ? 1 : 0;
  }
  return (100 * changed) / (WIDTH * HEIGHT);
}
