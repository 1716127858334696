// What the tests call in the page.
import * as behaviour from './behaviour.js';
import { compareDetail } from './detail.js';
import { compareImpostors } from './impostors.js';
import { madeCharacter } from './made.js';
import { comparePositions } from './numbers.js';
import { comparePictures } from './pictures.js';
import { readmeLines, readmePicture, readmeStream } from './readmes.js';
import { sentBytes } from './sent.js';
import { makeRenderer } from './stage.js';
import { stream, streamFaults } from './stream.js';
import { compareVariants } from './variants.js';

const renderers = new Map();

/** The renderer of tests that share a page. */
async function rendererOf(kind) {
  if (!renderers.has(kind)) {
    renderers.set(kind, await makeRenderer(kind));
  }
  return renderers.get(kind);
}

window.tests = {
  async babylon(url, clip) {
    const { babylonPicture } = await import('./babylon.js');
    return babylonPicture(await makeRenderer('webgl'), url, clip);
  },
  readmeLines,
  readmePicture,
  readmeStream,
  positions: comparePositions,
  socketDistance: behaviour.socketDistance,
  motions: behaviour.motions,
  hits: behaviour.hits,
  budgetAndViews: behaviour.budgetAndViews,
  hostile: behaviour.hostile,
  clipEvents: behaviour.clipEvents,
  faces: behaviour.faces,
  otherFormat: behaviour.otherFormat,
  preparing: behaviour.preparing,
  disposals: async (kind, times) => behaviour.disposals(await makeRenderer(kind), times),
  contextLoss: async (kind) => behaviour.contextLoss(await makeRenderer(kind)),
  stream: async (kind, ...args) => stream(await makeRenderer(kind), ...args),
  streamFaults,
  detail: async (kind, url, clip, cache) => compareDetail(await makeRenderer(kind), kind, url, clip, cache),
  variants: async (kind) => compareVariants(await rendererOf(kind), kind),
  roles: behaviour.roles,
  sentBytes: async (url, clip) => sentBytes(await rendererOf('webgpu'), url, clip),
  impostors: async (kind, url, clip) => compareImpostors(await rendererOf(kind), kind, url, clip),
  pictures: async (kind, url, clip) => comparePictures(await rendererOf(kind), kind, url, clip),
  async made(kind) {
    const url = URL.createObjectURL(new Blob([await madeCharacter()]));
    return comparePictures(await rendererOf(kind), kind, url, 'wave', true);
  },
};
