// Bytes that a frame of a crowd sends with WebGPU.
import { ArticulaLoader } from '@articula/three';

import { draw, makeStage } from './stage.js';

const COUNT = 30;
const MATRIX_BYTES = 48;

/** Bytes that frames write to storage buffers: that of the same places, and after one character or all moved. */
export async function sentBytes(renderer, url, clip) {
  const { ArticulaCrowd } = await import('@articula/three/webgpu');
  const loader = new ArticulaLoader();
  loader.prepare = false;
  const asset = await loader.loadAsync(url);
  const { scene, camera } = makeStage(2, 5);
  const crowd = new ArticulaCrowd(asset, COUNT, { clips: [clip], poseCache: false });
  const { queue } = renderer.backend.device;
  const { writeBuffer } = queue;
  let sent = 0;
  queue.writeBuffer = (buffer, offset, data, from = 0, size = data.length - from) => {
    sent += (buffer.usage & GPUBufferUsage.STORAGE) === 0 ? 0 : size * (data.BYTES_PER_ELEMENT ?? 1);
    writeBuffer.call(queue, buffer, offset, data, from, size);
  };
  const frame = (change) => {
    change();
    crowd.update(1 / 60, camera, renderer);
    sent = 0;
    draw(renderer, scene, camera);
    return sent - MATRIX_BYTES * crowd.core.paletteMatrices;
  };
  const place = (i) => crowd.place(i, (i % 6) - 2.5, 0, Math.floor(i / 6) - 2);
  for (let i = 0; i < COUNT; i += 1) {
    place(i).play(i, clip, 0.1 * i);
  }
  scene.add(crowd);
  // What is drawn first is made whole, and so is what grows.
  crowd.setFullDetail();
  frame(() => undefined);
  const beside = {
    still: frame(() => undefined),
    one: frame(() => place(7)),
    two: frame(() => place(7) && place(9)),
    fewer: frame(() => crowd.setTolerance(4)),
  };
  const matrices = crowd.core.paletteMatrices;
  queue.writeBuffer = writeBuffer;
  crowd.dispose();
  asset.dispose();
  return { beside, matrices, matrixBytes: MATRIX_BYTES };
}
