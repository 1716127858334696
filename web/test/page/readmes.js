// Runs the examples of the READMEs with a made character.
import { madeCharacter } from './made.js';

/** Runs code as a module of this page, with `character.glb` beside it. */
async function runModule(code) {
  await fetch('character.glb', { method: 'PUT', body: await madeCharacter() });
  await import(URL.createObjectURL(new Blob([code], { type: 'text/javascript' })));
}

/** The picture after some frames, and how many colours it has. */
export async function readmePicture(code) {
  await runModule(code);
  const canvas = document.querySelector('canvas');
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext('2d');
  for (let frame = 0; frame < 4; frame += 1) {
    await new Promise(requestAnimationFrame);
  }
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  const colors = new Set();
  for (let at = 0; at < data.length; at += 4) {
    colors.add((data[at] << 16) | (data[at + 1] << 8) | data[at + 2]);
  }
  const png = new Uint8Array(await (await copy.convertToBlob()).arrayBuffer());
  return { colors: colors.size, png: btoa(Array.from(png, (byte) => String.fromCharCode(byte)).join('')) };
}

/** What the example prints. */
export async function readmeLines(code) {
  const printed = [];
  const { log } = console;
  console.log = (line) => printed.push(line);
  try {
    await runModule(code);
  } finally {
    console.log = log;
  }
  return printed;
}
