// The scene of all contenders: a square of characters that play one clip from different times, seen by a camera at
// the middle of its edge.
import * as THREE from 'three';

/** Metres between neighbours. */
const SPACING = 1.5;
/** Size of the picture for which details are chosen, pixels. */
export const VIEW = { width: 1280, height: 720 };

/** Place of a character on the ground, and the time in seconds from which it plays. */
export function character(index, count) {
  const side = Math.ceil(Math.sqrt(count));
  const x = SPACING * ((index % side) - (side - 1) / 2);
  const z = -SPACING * Math.floor(index / side);
  return { x, z, secs: (index * 0.379) % 10 };
}

/** The camera, which looks along the square. */
export function makeCamera({ width, height } = VIEW) {
  const camera = new THREE.PerspectiveCamera(45, width / height, 0.1, 500);
  camera.position.set(0, 1.7, 3);
  camera.lookAt(0, 1.2, -10);
  camera.updateMatrixWorld();
  return camera;
}
