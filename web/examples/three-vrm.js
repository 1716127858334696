// A VRM by three-vrm among a crowd of itself, which it joins as the camera leaves.
import { ArticulaLoader } from '@articula/three';
import { VRMLoaderPlugin } from '@pixiv/three-vrm';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

import { crowdAround } from './crowded-vrm.js';

/** Shows a file on a canvas; resolves to its parts and a function that shows the next frame. */
export async function showVrm(canvas, url, count) {
  const loader = new GLTFLoader().register((parser) => new VRMLoaderPlugin(parser, { autoUpdateHumanBones: false }));
  const { vrm } = (await loader.loadAsync(url)).userData;
  const asset = await new ArticulaLoader().loadAsync(url);
  const { crowd, hero } = crowdAround(vrm, asset, count);

  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x8899aa);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x556655, 2.5));
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(1, 2, 3);
  scene.add(sun, vrm.scene, crowd);
  const height = asset.bounds.max.y - asset.bounds.min.y;
  const camera = new THREE.PerspectiveCamera(35, 2, height / 20, 60 * height);
  const side = Math.ceil(Math.sqrt(count));
  for (let i = 1; i < count; i += 1) {
    crowd.place(i, height * ((i % side) - (side - 1) / 2), 0, -height * (1 + Math.floor(i / side)));
  }
  const [clip] = asset.clips;
  if (clip !== undefined) {
    hero.play(clip);
    for (let i = 1; i < count; i += 1) {
      crowd.play(i, clip, 0.37 * i);
    }
  }

  function frame(secs, metres = 2.2 * height) {
    const { clientWidth: width, clientHeight: tall } = canvas;
    renderer.setSize(width, tall, false);
    camera.aspect = width / tall;
    camera.position.set(0, 0.9 * height, metres);
    camera.lookAt(0, 0.6 * height, 0);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    vrm.lookAt?.lookAt(camera.position);
    hero.update(secs, camera, { width, height: tall });
    crowd.update(secs, camera, renderer);
    renderer.render(scene, camera);
  }

  frame(0);
  return { renderer, scene, vrm, crowd, hero, frame };
}
