// What the tests call in the page.
import { madeCharacter } from './made.js';
import { comparePictures } from './pictures.js';
import { makeRenderer } from './stage.js';

const renderers = new Map();

async function rendererOf(kind) {
  if (!renderers.has(kind)) {
    renderers.set(kind, await makeRenderer(kind));
  }
  return renderers.get(kind);
}

window.tests = {
  async pictures(kind, url, clip) {
    return comparePictures(await rendererOf(kind), kind, url, clip);
  },
  async made(kind) {
    const url = URL.createObjectURL(new Blob([await madeCharacter()]));
    return comparePictures(await rendererOf(kind), kind, url, 'wave');
  },
};
