// Numbers of figures and crowds beside three.js's own.

/** 0.1 mm. */
const MOST_METRES = 1e-4;

// At a time of a key where keys are far apart: between them, rotations are interpolated in another way.
const CASES = [
  ['glb/Quaternius_single_knight_pack__KnightCharacter.glb', 'HumanArmature|Roll_sword', 0.61],
  ['glb/pab_arnaud.glb', 'atlas', 0.37],
  ['glb/RobotExpressive.glb', 'Robot_Jump', 0.25],
];

export const NUMBERS = CASES.map(([file, clip, secs]) => ({
  name: `numbers ${file.split('/')[1]}`,
  share: 'plain',
  call: ['positions', [`/assets/${file}`, clip, secs]],
  check({ vertices, figure, crowd, outside, tight }) {
    const faults = [];
    if (new Set(vertices).size !== 1) {
      faults.push(`numbers of vertices: ${vertices.join(', ')}`);
    }
    if (!(figure <= MOST_METRES)) {
      faults.push(`a vertex of the figure is ${(1000 * figure).toFixed(3)} mm off`);
    }
    if (!(crowd <= MOST_METRES)) {
      faults.push(`a vertex of the crowd is ${(1000 * crowd).toFixed(3)} mm off`);
    }
    if (outside > MOST_METRES) {
      faults.push(`a vertex is ${outside.toFixed(3)} m outside of the bounding sphere`);
    }
    if (tight < 0.5) {
      faults.push(`the bounding sphere is ${(1 / tight).toFixed(1)} times as large as needed`);
    }
    const mm = [figure, crowd].map((metres) => `${(1000 * metres).toFixed(4)} mm`);
    console.log(`        figure ${mm[0]} off, crowd ${mm[1]}, sphere ${(1 / tight).toFixed(2)} times the least`);
    return faults;
  },
}));
