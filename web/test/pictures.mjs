// Pixels of figures and crowds beside three.js's own.
import { existsSync } from 'node:fs';
import { join } from 'node:path';

import { DATA } from './server.mjs';

/** Pixels that may differ by more than 8 levels, in percent. */
const MOST_PERCENT = 0.5;
/** Pixels that a character and its shadow change at least, in percent. */
const LEAST_SHOWN = 2;

// Those with a number of draws have 3 to 8 materials that differ in colour alone.
const FILES = [
  { file: 'glb/Quaternius_single_knight_pack__KnightCharacter.glb', clip: 'HumanArmature|Run_swordAttack', draws: 1 },
  { file: 'glb/pab_arnaud.glb', clip: 'walk' },
  { file: 'glb/Quaternius_modular_men__Suit.glb', clip: undefined, draws: 1 },
  { file: 'glb/RobotExpressive.glb', clip: 'Robot_Dance', draws: 1 },
  { file: 'glb/ict_head_talk_554.glb', clip: 'talk_turn', draws: 1 },
  { file: 'vrm/debug_robot.vrm', clip: undefined },
];

/** Of the full set: many clips and parts; a human of many vertices and joints. */
const DATA_FILES = [
  { file: 'glb/KayKit_Knight.glb', clip: 'Walking_A' },
  { file: 'glb/mh_female_dance.glb', clip: 'dance' },
];

async function check(result, save) {
  const faults = result.warnings.filter((line) => line.startsWith('material'));
  for (const part of ['figure', 'crowd']) {
    const { percent, shown, png } = result[part];
    await save(part, png);
    console.log(`        ${part}: ${percent.toFixed(3)} % differ, ${shown.toFixed(1)} % show it`);
    if (percent > MOST_PERCENT) {
      faults.push(`${part}: ${percent.toFixed(2)} % of the pixels differ, the most is ${MOST_PERCENT}`);
    }
    if (shown < LEAST_SHOWN) {
      faults.push(`${part}: ${shown.toFixed(2)} % of the pixels show it, the least is ${LEAST_SHOWN}`);
    }
  }
  return faults;
}

const EXAMPLES = [
  {
    name: 'example babylon',
    call: ['babylon', ['/assets/glb/pab_arnaud.glb', 'walk']],
    async check({ percent, png, shown }, save) {
      await save('outlines', png);
      console.log(`        ${percent.toFixed(3)} % differ, ${shown.toFixed(1)} % show it`);
      return percent <= MOST_PERCENT && shown >= LEAST_SHOWN ? [] : ['the outlines differ'];
    },
  },
];

export const PICTURES = ['webgl', 'webgpu-webgl', 'webgpu'].flatMap((kind) => [
  { name: `pictures ${kind} made`, share: kind, call: ['made', [kind]], check },
  ...FILES.map(({ file, clip, draws }) => ({
    name: `pictures ${kind} ${file.split('/')[1]}`,
    share: kind,
    call: ['pictures', [kind, `/assets/${file}`, clip]],
    async check(result, save) {
      const found = result.crowd.draws;
      const isOther = draws !== undefined && found !== draws;
      return [...(await check(result, save)), ...(isOther ? [`${found} draws, expected ${draws}`] : [])];
    },
  })),
]).concat(ofData(), EXAMPLES);

/** Pictures of the full set, by one renderer: the others take its arrays alike. */
function ofData() {
  const [there, missing] = [true, false].map((is) => DATA_FILES.filter(({ file }) => existsSync(join(DATA, file)) === is));
  for (const { file } of missing) {
    console.log(`skipped: pictures of ${file}, not in ${DATA} (set ARTICULA_DATA)`);
  }
  return there.map(({ file, clip }) => ({
    name: `pictures webgl ${file.split('/')[1]}`,
    share: 'webgl',
    call: ['pictures', ['webgl', `/data/${file}`, clip]],
    check,
  }));
}
