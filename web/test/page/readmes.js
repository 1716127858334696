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
  return picture();
}

/** The same once the example has printed what it waits for, and what it prints. */
export async function readmeStream(code) {
  const printed = await printedBy(code, (lines) => lines.length > 0);
  return { ...(await picture()), printed };
}

async function picture() {
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
  return printedBy(code, () => true);
}

/** What code prints until `isDone`, for so many frames at most. */
async function printedBy(code, isDone, frames = 2000) {
  const printed = [];
  const { log } = console;
  console.log = (line) => printed.push(line);
  try {
    await runModule(code);
    for (let frame = 0; frame < frames && !isDone(printed); frame += 1) {
      await new Promise(requestAnimationFrame);
    }
  } finally {
    console.log = log;
  }
  return printed;
}
