// What figures, crowds and the loader do beside being drawn.

const unless = (right, fault) => (right ? [] : [fault]);
const KNIGHT = '/assets/glb/Quaternius_single_knight_pack__KnightCharacter.glb';

/** Pixels of a crowd by a tolerance of one pixel that may differ from all joints, in percent. */
const MOST_LEFT_OUT = 3;

const detail = (kind, cache, list) => ({
  name: `detail ${kind} ${cache}`,
  call: ['detail', [kind, KNIGHT, 'HumanArmature|Walking', cache]],
  async check({ percent, png, shown, few, again, drawn, levels }, save) {
    await save('crowd', png);
    const numbers = `${percent.toFixed(2)} % differ, ${shown.toFixed(1)} % show it`;
    console.log(`        ${numbers}, drawn`, drawn, 'levels', levels);
    return [
      ...unless(percent < MOST_LEFT_OUT, `${percent.toFixed(2)} % of the pixels differ`),
      ...unless(shown > 5, 'nothing is shown'),
      ...unless(few > 0 && few < 12, `the first camera sees ${few}`),
      ...unless(again === 0, `${again} % of the pixels differ when buffers shrink`),
      ...unless(drawn[list] > 0, `there are no ${list}`),
    ];
  },
});

/** Pixels of an outline that may be off by more than the tolerance, in percent: the error is that of 95 % of a character. */
const MOST_OFF = 5;

const impostors = (kind) => ({
  name: `impostors ${kind}`,
  share: 'impostors',
  call: ['impostors', [kind, KNIGHT, 'HumanArmature|Walking']],
  async check({ views, tolerance, count, nearby, errorM, usual, tinted }, save) {
    const faults = unless(tolerance < 5, `the tolerance is ${tolerance} px`);
    for (const [i, { png, impostors, share, lost, added, means }] of views.entries()) {
      await save(`${i}`, png);
      const colours = means.map((mean) => mean.map((level) => level.toFixed(0)).join(' '));
      console.log(`        ${lost.toFixed(2)} % lost, ${added.toFixed(2)} % added of ${share.toFixed(1)} %, colours ${colours.join(' and ')}, ${(100 * errorM).toFixed(1)} cm, ${tolerance.toFixed(1)} px`);
      faults.push(
        ...unless(impostors === count, `${impostors} of ${count} are impostors`),
        ...unless(share > 2, `${share} % of the pixels show them`),
        ...unless(lost < MOST_OFF && added < MOST_OFF, `${lost} % are lost, ${added} % added`),
      );
    }
    return [
      ...faults,
      ...unless(nearby < count / 2, `nearby ${nearby} are impostors`),
      ...unless(tinted[1] < 0.9 * usual[1] && tinted[0] > 0.98 * usual[0], `coloured red they are ${tinted}, else ${usual}`),
    ];
  },
});

export const BEHAVIOUR = [
  ...['webgl', 'webgpu-webgl', 'webgpu'].map(impostors),
  ...['webgl', 'webgpu-webgl', 'webgpu'].flatMap((kind) => [
    detail(kind, 'cpu', 'stepped'),
    detail(kind, 'gpu', 'records'),
  ]),
  ...['webgl', 'webgpu-webgl', 'webgpu'].map((kind) => ({
    name: `variants ${kind}`,
    share: kind,
    call: ['variants', [kind]],
    async check({ percent, png, shown, variants, warnings, again, figure, unknown, changed }, save) {
      await save('crowd', png);
      console.log(`        ${percent.toFixed(3)} % differ, ${changed.toFixed(1)} % are others than usual, figure ${figure.toFixed(3)} %`);
      return [
        ...unless(percent < 0.5 && figure < 0.5, `${percent} % of the crowd differ, ${figure} % of the figure`),
        ...unless(changed > 1 && shown > 2, `${changed} % change`),
        ...unless(again === 0, `${again} % differ when variants are taken back`),
        ...unless(variants.join() === 'usual,painted' && warnings.length === 0, `${variants}; ${warnings}`),
        ...unless(unknown.includes('no variant "gold"'), unknown),
      ];
    },
  })),
  {
    name: 'with WebGPU what changed is sent',
    share: 'webgpu',
    call: ['sentBytes', [KNIGHT, 'HumanArmature|Walking']],
    check: ({ beside, matrices, matrixBytes }) => [
      ...unless(matrices > 0, 'no palette is drawn'),
      ...unless(beside.still === 0 && beside.fewer === 0, `beside palettes ${JSON.stringify(beside)} bytes are sent`),
      // Those between two are sent too.
      ...unless(beside.one === matrixBytes && beside.two === 3 * matrixBytes, JSON.stringify(beside)),
    ],
  },
  {
    name: 'roles decide who shows more',
    share: 'plain',
    call: ['roles', []],
    check: ({ levels, raised, own, left, unknown }) => [
      ...unless(levels[0] < levels[1] && levels[1] < levels[2], `levels ${levels}`),
      // Levels change late, so that they do not flicker.
      ...unless(raised < levels[2], `a role raised to 4 shows level ${raised} of ${levels}`),
      ...unless(own < levels[1] && own <= left, `an importance of 16 shows level ${own} of ${levels}, then ${left}`),
      ...unless(unknown.includes('no role "king"'), unknown),
    ],
  },
  {
    name: 'an object in a socket follows the joint',
    share: 'plain',
    call: ['socketDistance', ['RightHand']],
    check: (metres) => unless(metres < 1e-4, `the object is ${metres} m off`),
  },
  {
    name: 'figures fade, add layers, turn joints and leave out what is far',
    share: 'plain',
    call: ['motions', []],
    check: ({ apart, angle, returned }) => [
      ...['faded', 'layered', 'turned'].flatMap((name) => unless(apart[name] < 1e-3, `${name}: ${apart[name]} m`)),
      ...unless(apart.far < 0.3, `far: ${apart.far} m`),
      ...unless(Math.abs(angle - Math.PI / 2) < 1e-3, `the head turns by ${angle}`),
      ...unless(returned < 1e-3, `the head is ${returned} off when it is let go`),
    ],
  },
  {
    name: 'rays hit the characters where they stand',
    share: 'plain',
    call: ['hits', []],
    check: ({ found, missed, onFigure }) => [
      ...found.flatMap((hit, i) => unless(hit?.character === i && hit.off < 2, `at ${i} hit ${JSON.stringify(hit)}`)),
      ...unless(missed, 'a ray beside them hits'),
      ...unless(Math.abs(onFigure) < 0.5, `the ray hits the figure at ${onFigure}`),
    ],
  },
  {
    name: 'a budget raises the tolerance, and each of several cameras shows what it sees',
    share: 'plain',
    call: ['budgetAndViews', []],
    check: ({ seen, tolerance }) => [
      ...unless(tolerance > 1, `the tolerance is ${tolerance} px`),
      ...unless(seen.none === 0 && seen.one > 0 && seen.both === seen.one, JSON.stringify(seen)),
    ],
  },
  {
    name: 'files that are none throw errors with their names',
    share: 'plain',
    call: ['hostile', []],
    check: ({ errors, clips, clip }) => [
      ...errors.flatMap((error) => unless(error.own && error.code && error.file === 'bad.glb', JSON.stringify(error))),
      ...unless(clips.includes('wave'), `the next file has the clips ${clips}`),
      ...unless(clip.includes('no clip "no such"'), `an unknown clip says: ${clip}`),
    ],
  },
  {
    name: 'disposals release all memory',
    call: ['disposals', ['webgl', 100]],
    check: ({ half, last }) =>
      unless(JSON.stringify(half) === JSON.stringify(last), `${JSON.stringify(half)}, then ${JSON.stringify(last)}`),
  },
  {
    name: 'a lost context comes back',
    call: ['contextLoss', ['webgl']],
    async check({ percent, png, colors }, save) {
      await save('crowd', png);
      return [
        ...unless(percent === 0, `${percent} % of the pixels differ`),
        ...unless(colors === 4, `the crowd shows ${colors} of 4 colours`),
      ];
    },
  },
  {
    name: 'faces take expressions and morph targets by name',
    share: 'plain',
    call: ['faces', []],
    check: ({ known, unknown, set, cleared }) => [
      ...unless(known && !unknown, `known ${known}, unknown ${unknown}`),
      ...unless(Math.abs(set[0] - 1) < 1e-6 && set[1] === 0.25 && cleared === 0, JSON.stringify({ set, cleared })),
    ],
  },
  {
    name: 'figures and crowds tell the events of clips',
    share: 'plain',
    call: ['clipEvents', []],
    check: ({ clip, told, code, message }) => [
      ...unless(
        JSON.stringify(told) === JSON.stringify([[undefined, clip, 11], [undefined, clip, 12], [0, clip, 11], [1, clip, 12]]),
        `told: ${JSON.stringify(told)}`,
      ),
      ...unless(code === 'argument' && message.includes('"fly"'), `${code}: ${message}`),
    ],
  },
  {
    name: 'files of other formats open by a worker',
    share: 'plain',
    call: ['otherFormat', []],
    check: ({ clips, joints }) => unless(clips === 1 && joints > 15, `${clips} clips, ${joints} joints`),
  },
  {
    name: 'a worker prepares, and can be ended',
    share: 'plain',
    call: ['preparing', []],
    check: ({ cancelled, steps, prepared, warnings, clips }) => [
      ...unless(cancelled === 'cancelled', `ending it gives ${cancelled}`),
      ...unless(steps > 1, `${steps} steps are told`),
      ...unless(prepared && warnings.length === 0, `prepared: ${prepared}; ${warnings}`),
      ...unless(clips.includes('wave'), `clips: ${clips}`),
    ],
  },
];
