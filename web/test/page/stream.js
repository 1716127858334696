// Characters of a server, while they arrive.
import { ArticulaStream } from '@articula/three';

import { compare, draw, makeStage, shown } from './stage.js';

/** Frames after which a stream that is not complete is given up; the page draws as fast as it can. */
const MOST_FRAMES = 20_000;

/** Notes the ranges of objects that are fetched and have come. */
function watchFetch() {
  const fetched = [];
  const original = window.fetch;
  window.fetch = async (url, options) => {
    const answer = await original(url, options);
    const object = /\/v1\/o\/([0-9a-f]{64})/.exec(String(url))?.[1];
    if (object !== undefined && answer.ok) {
      const body = await answer.clone().arrayBuffer();
      const [, start = 0] = /bytes=(\d+)-/.exec(options?.headers?.Range ?? '') ?? [];
      fetched.push({ object, start: Number(start), end: Number(start) + body.byteLength });
    }
    return answer;
  };
  return {
    fetched,
    end: () => {
      window.fetch = original;
    },
  };
}

/** Bytes that came more than once. */
function twice(fetched) {
  let bytes = 0;
  for (const [i, one] of fetched.entries()) {
    for (const other of fetched.slice(0, i).filter(({ object }) => object === one.object)) {
      bytes += Math.max(0, Math.min(one.end, other.end) - Math.max(one.start, other.start));
    }
  }
  return bytes;
}

/** Plays a stream until `isDone`; returns whether it was. */
async function playUntil(stream, camera, isDone) {
  for (let frame = 0; frame < MOST_FRAMES && !isDone(); frame += 1) {
    stream.update(1 / 60, camera);
    // As a page draws, but as fast as it can: tasks of the network run between frames.
    await new Promise((resolve) => setTimeout(resolve));
  }
  return isDone();
}

const triangles = ({ mesh }) => mesh.geometry.index.count / 3;

/** Shows a character from its base until all has come; `window.stopServer` kills the server, `window.startServer` starts it again. */
export async function stream(renderer, server, name, by) {
  const watched = watchFetch();
  const { scene, camera } = makeStage(3, 1);
  const empty = draw(renderer, scene, camera);
  const before = { ...renderer.info.memory };
  const figure = new ArticulaStream(server, name, { by, context: { network: { available_bps: 4e6 } } });
  const states = [];
  let [lost, refined] = [0, 0];
  figure.addEventListener('state', ({ state }) => states.push(state));
  figure.addEventListener('lost', () => (lost += 1));
  figure.addEventListener('refined', () => (refined += 1));
  scene.add(figure);
  await figure.ready;
  const { mesh } = figure;
  figure.update(0, camera);
  const atBase = { triangles: triangles(figure), report: figure.report, shown: shown(empty, draw(renderer, scene, camera)) };
  await window.stopServer();
  // A browser may ask again by itself what a connection that is cut has not answered.
  await playUntil(figure, camera, () => lost > 0);
  await window.startServer();
  const isComplete = await playUntil(figure, camera, () => figure.state === 'complete' && refined > 1);
  figure.play(figure.clips[0], 0.2).update(0, camera);
  const last = { triangles: triangles(figure), report: figure.report, clips: figure.clips };
  const picture = draw(renderer, scene, camera);
  const isSame = figure.mesh === mesh;
  figure.dispose();
  draw(renderer, scene, camera);
  watched.end();
  const { geometries, textures } = renderer.info.memory;
  const left = { geometries: geometries - before.geometries, textures: textures - before.textures };
  return {
    states,
    lost,
    refined,
    isComplete,
    isSame,
    atBase,
    last: { ...last, shown: shown(empty, picture), png: (await compare(empty, picture)).png },
    twice: twice(watched.fetched),
    requests: watched.fetched.length,
    left: Object.keys(left).filter((what) => left[what] > 0),
  };
}

/** What a stream says of a character that is not there, and of a server that is none. */
export async function streamFaults(server) {
  const missing = new ArticulaStream(server, 'no such');
  const events = [];
  missing.addEventListener('error', ({ error }) => events.push(error.code));
  const error = await missing.ready.catch((reason) => reason);
  missing.dispose();
  const ended = new ArticulaStream('http://127.0.0.1:9/', 'knight');
  let lost = '';
  const told = new Promise((resolve) => ended.addEventListener('lost', resolve));
  ended.addEventListener('lost', ({ why }) => (lost = why));
  await told;
  ended.dispose();
  const cancelled = await ended.ready.catch((reason) => reason);
  return { code: error.code, message: error.message, file: error.file, events, lost, cancelled: cancelled.code };
}
