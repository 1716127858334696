// Characters as three.js itself shows them.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import * as SkeletonUtils from 'three/addons/utils/SkeletonUtils.js';

/** Loads a file; returns a function that makes a figure at a time of a clip. */
export async function theirs(url) {
  const { scene, animations } = await new GLTFLoader().loadAsync(url);
  return (clip, secs) => {
    const figure = SkeletonUtils.clone(scene);
    figure.traverse((object) => {
      if (object.isMesh) {
        object.castShadow = true;
        object.receiveShadow = true;
        object.frustumCulled = false;
      }
    });
    const animation = animations.find(({ name }) => name === clip);
    if (animation !== undefined) {
      const mixer = new THREE.AnimationMixer(figure);
      mixer.clipAction(animation).play();
      mixer.setTime(secs);
    }
    return figure;
  };
}
