// Characters of a server, while they arrive.
import { example } from './readmes.mjs';
import { openStore, PROGRAM } from './store.mjs';

const unless = (right, fault) => (right ? [] : [fault]);
const KNIGHT = 'glb/Quaternius_single_knight_pack__KnightCharacter.glb';
const NAME = 'knight';
// Browsers write to the console what a server does not answer, or not have.
const EXPECTED = /net::ERR|WebSocket|status of 404/;

/** What all tests of streams share: the server packages once. */
let store;

/** Opens the store for a page, which may end its server and start it again. */
async function open(page) {
  // So slow that the server can be ended before all has come.
  store ??= await openStore(KNIGHT, 'HumanArmature|Walking', NAME, ['--throttle-kbps', '100']);
  await page.exposeFunction('stopServer', store.stop);
  await page.exposeFunction('startServer', store.start);
  return {
    args: [store.url, NAME],
    forgive: (errors) => errors.splice(0, errors.length, ...errors.filter((error) => !EXPECTED.test(error))),
  };
}

/** Ends the server of the tests. */
export async function closeStore() {
  await store?.close();
}

const stream = (by, requests) => ({
  name: `stream by ${by}`,
  open: async (page) => {
    const opened = await open(page);
    return { ...opened, args: [...opened.args, by] };
  },
  call: ['stream', ['webgl']],
  async check({ states, lost, refined, isComplete, isSame, atBase, last, twice, left, ...rest }, save) {
    await save('last', last.png);
    console.log(
      `        ${atBase.report.bytes} bytes and ${atBase.triangles} triangles at first, then ${last.report.bytes} and`,
      `${last.triangles}; ${refined} meshes, ${rest.requests} requests, lost ${lost} times`,
    );
    return [
      ...unless(isComplete && last.report.isComplete, `it ends at ${JSON.stringify(last.report)}`),
      ...unless(states[0] === 'base' && states.at(-1) === 'complete', `states: ${states}`),
      ...unless(atBase.shown > 2 && last.shown > 2, `pixels: ${atBase.shown} %, then ${last.shown} %`),
      ...unless(last.triangles > 2 * atBase.triangles, `triangles: ${atBase.triangles}, then ${last.triangles}`),
      ...unless(last.report.bytes > 1.2 * atBase.report.bytes, `bytes: ${atBase.report.bytes}, then ${last.report.bytes}`),
      ...unless(isSame && refined > 1, `refined ${refined} times, in the same mesh: ${isSame}`),
      ...unless(twice === 0, `${twice} bytes are fetched twice`),
      ...unless(requests(rest.requests), `${rest.requests} requests`),
      ...unless(lost > 0, 'the server that was killed is not missed'),
      ...unless(last.clips.join() === 'HumanArmature|Walking', `clips: ${last.clips}`),
      ...unless(left.length === 0, `left behind: ${left}`),
    ];
  },
});

const README = await example('three', 1);

const ALL = [
  stream('http', (count) => count > 4),
  stream('session', (count) => count === 0),
  {
    name: 'readme stream',
    async open(page) {
      const { args } = await open(page);
      const [url, name] = args;
      const code = README.replace('http://127.0.0.1:8080', url).replace("'character'", `'${name}'`);
      return { args: [code] };
    },
    call: ['readmeStream', []],
    async check({ colors, png, printed }, save) {
      await save('page', png);
      return [
        ...unless(colors > 100, `the picture has ${colors} colours`),
        ...unless(printed[0] === 'base', `it prints ${printed}`),
      ];
    },
  },
  {
    name: 'stream of what is not there',
    open,
    call: ['streamFaults', []],
    check: ({ code, message, file, events, lost, cancelled }) => [
      ...unless(code === 'missing' && file === 'no such' && /no such/.test(message), `${code}: ${message}`),
      ...unless(events.join() === 'missing', `events: ${events}`),
      ...unless(lost !== '' && cancelled === 'cancelled', `lost: ${lost}; then ${cancelled}`),
    ],
  },
];

if (PROGRAM === undefined) {
  console.log('skipped: streams, no program (build it, or set ARTICULA to it)');
}

export const STREAMS = PROGRAM === undefined ? [] : ALL;
