// Times faces in Chromium, in turns: meshes by three.js, and portraits by their own player, both without a
// graphics card: `node portrait_times.mjs < JOB`.
//
// JOB is {width, height, frames, rounds, subjects: [{kind, file}]}: kind is "mesh" for a GLB file, whose morph targets
// move, or "portrait" for a page of ours. In each round each subject shows so many frames, and every frame is waited
// for until its pixels are there. Prints a list with {triangles, vertices, ms: [of a frame in each round]} for each.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, extname, resolve, sep } from "node:path";
import { text as readAll } from "node:stream/consumers";
import { chromium } from "playwright-core";
import { findChromium, openPage, ORIGIN } from "./chromium.mjs";

const THREE = dirname(dirname(createRequire(import.meta.url).resolve("three")));
const TYPES = { ".html": "text/html;charset=utf-8", ".js": "text/javascript;charset=utf-8", ".glb": "model/gltf-binary" };

const MESH_PAGE = `<!DOCTYPE html><style>html,body{margin:0}</style><canvas id="canvas"></canvas>
<script type="importmap">{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
const { width, height } = window.SIZE;
const renderer = new THREE.WebGLRenderer({ canvas: document.getElementById("canvas"), antialias: true });
renderer.setSize(width, height);
const scene = new THREE.Scene();
const sun = new THREE.DirectionalLight(0xffffff, 2);
sun.position.set(1, 2, 3);
scene.add(sun, new THREE.AmbientLight(0xffffff, 1));
const load = async () => {
  const { scene: head } = await new GLTFLoader().loadAsync("/subject.glb");
  scene.add(head);
  const { center, radius } = new THREE.Box3().setFromObject(head).getBoundingSphere(new THREE.Sphere());
  const camera = new THREE.PerspectiveCamera(30, width / height, radius / 10, radius * 10);
  camera.position.set(0, 0, 4.2 * radius).add(center);
  const meshes = [];
  head.traverse((node) => node.isMesh && meshes.push(node));
  const gl = renderer.getContext();
  const pixel = new Uint8Array(4);
  const shown = (frame) => {
    head.rotation.y = 0.5 * Math.sin(frame / 20);
    for (const { morphTargetInfluences: weights } of meshes) {
      weights?.forEach((_, i) => { weights[i] = 0.15 + 0.15 * Math.sin(frame / 7 + i); });
    }
    renderer.render(scene, camera);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  };
  shown(0);
  return { shown, triangles: renderer.info.render.triangles, vertices: meshes.reduce((sum, m) => sum + m.geometry.attributes.position.count, 0) };
};
window.subject = load();
</script>`;

/** In the page: the same for the player of a portrait. */
const takePortrait = () => {
  const face = window.articulaPortrait;
  face.stop();
  const names = face.json.expressions.map(({ name }) => name);
  const shown = (frame) => {
    const weights = Object.fromEntries(names.map((name, i) => [name, 0.15 + 0.15 * Math.sin(frame / 7 + i)]));
    face.pose({ yaw: 28 * Math.sin(frame / 20) }, weights);
    face.context.getImageData(0, 0, 1, 1);
  };
  window.subject = Promise.resolve({ shown, triangles: face.count, vertices: face.rest[0].length });
};

/** In the page: milliseconds of a frame. */
const time = async (frames) => {
  const { shown } = await window.subject;
  const start = performance.now();
  for (let frame = 0; frame < frames; frame++) shown(frame);
  return (performance.now() - start) / frames;
};

async function opened(browser, { kind, file }, { width, height }) {
  const body = await readFile(file);
  const answer = async (path) => {
    if (path === "/") return { contentType: TYPES[".html"], body: kind === "mesh" ? MESH_PAGE : body };
    if (path === "/subject.glb") return { contentType: TYPES[".glb"], body };
    const asked = resolve(THREE, path.replace("/three/", ""));
    if (!path.startsWith("/three/") || !asked.startsWith(THREE + sep)) return null;
    return { contentType: TYPES[extname(asked)] ?? "application/octet-stream", body: await readFile(asked) };
  };
  const page = await openPage(browser, { width, height }, answer);
  await page.addInitScript((size) => { window.SIZE = size; }, { width, height });
  await page.goto(`${ORIGIN}/`);
  if (kind === "portrait") {
    await page.evaluate(() => window.articulaReady);
    await page.evaluate(takePortrait);
  }
  const { triangles, vertices } = await page.evaluate(async () => {
    const { triangles, vertices } = await window.subject;
    return { triangles, vertices };
  });
  if (page.faults.length > 0) throw new Error(`${file}: ${page.faults.join("; ")}`);
  return { page, triangles, vertices, ms: [] };
}

const program = findChromium();
if (!program) process.exit(3);
const job = JSON.parse(await readAll(process.stdin));
const software = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--disable-sync", "--no-first-run"];
const browser = await chromium.launch({ executablePath: program, headless: true, chromiumSandbox: false, args: software });
try {
  const subjects = [];
  for (const subject of job.subjects) subjects.push(await opened(browser, subject, job));
  for (let round = -1; round < job.rounds; round++) {
    for (const subject of subjects) {
      await subject.page.bringToFront();
      const ms = await subject.page.evaluate(time, job.frames);
      // The first round warms up.
      if (round >= 0) subject.ms.push(ms);
    }
  }
  process.stdout.write(JSON.stringify(subjects.map(({ triangles, vertices, ms }) => ({ triangles, vertices, ms }))));
} finally {
  await browser.close();
}
