// Planes of the streams that `node fba.mjs golden FOLDER` writes, as fba.mjs describes them: with
// everything that the format leaves to a writer.

/** All parameters from one to another, with the value that `f` gives for each. */
const all = (first, last, f) =>
  Object.fromEntries(Array.from({ length: last - first + 1 }, (_, i) => [first + i, f(first + i)]));

const wave = (fap, t, size) => Math.round(size * Math.sin(0.37 * t + fap));

/** Visemes and expressions, mouth, head and lips; later another quantiser, other masks, and the ranges as they were. */
function speech() {
  const planes = [];
  for (let t = 0; t < 22; t++) {
    const values = {
      ...all(3, 18, (fap) => wave(fap, t, 90)),
      ...all(48, 50, (fap) => wave(fap, t, 9000)),
      ...all(51, 60, (fap) => wave(fap, t, 60)),
    };
    // One-sided parameters, and one that jumps.
    values[3] = Math.abs(values[3]) * 5;
    values[49] = t % 7 === 5 ? -33000 : values[49];
    planes.push({
      intra: false,
      viseme: [(3 * t) % 15, (5 * t + 2) % 15, (17 * t) % 64, t % 2],
      expression: [t % 7, (63 - 9 * t + 640) % 64, (t + 3) % 7, (11 * t) % 64, t % 3 === 0 ? 1 : 0, 1],
      values,
    });
  }
  const masks = ["3", "3", "0", "0", "0", "0", "3", "2 1101111111", "0", "0"];
  const least = (k) => [...Array(16).fill(k), 31, 31, 31, ...Array(9).fill(k)];
  Object.assign(planes[0], {
    intra: true,
    startCode: true,
    frameRate: [25, 0, 0],
    timeCode: [1, 2, 3],
    quantiser: 1,
    masks,
    gender: 1,
    ranges: [least(5), least(3), least(2), null],
  });
  planes[4].skip = 3;
  // Blends of 32 steps of 2 are 64, one more than there are: shown as 63, but predicted from.
  Object.assign(planes[9], { intra: true, startCode: true, quantiser: 2, masks, gender: 0, ranges: [null, null, null, null] });
  for (const t of [9, 10, 11]) planes[t].viseme[2] = [63, 61, 30][t - 9];
  planes[11].skip = 15;
  Object.assign(planes[15], {
    intra: true,
    quantiser: 0,
    masks: ["1 10", "1 1000000110000001", "0", "0", "0", "0", "0", "1 0000000001", "0", "0"],
    gender: 1,
    ranges: [null, [9, 2, 2, 2, 3], null, [4, 2, 2, 2, 2]],
  });
  // Back within the 32 levels that the quantiser of 2 left.
  for (let t = 15; t < 22; t++) planes[t].viseme[2] = (5 * t) % 32;
  planes[21].skip = 0;
  return planes;
}

/** Visemes alone, so runs without a symbol; runs that end in 22 zeros, and runs of more zeros; then rest. No rate. */
function zeros() {
  const planes = [];
  const of = (masks, values) => {
    planes.push({ intra: true, quantiser: 1, masks, ranges: [null, null, null, null], values });
    planes.push({ intra: false, values });
  };
  for (let t = 0; t < 6; t++) planes.push({ intra: false, viseme: [t, 0, 10 * t, 0], values: {} });
  const mouth = ["1 10", "0", "0", "0", "0", "0", "0", "0", "0", "0"];
  Object.assign(planes[0], { intra: true, quantiser: 1, masks: mouth, ranges: [null, null, null, null] });
  // The whole interval, its middle of 3721 and the 509th of 1081 parts: a 1 and 22 zeros.
  of(["0", "0", "0", "0", "0", "0", "1 100", "0", "1 1000", "0"], { 48: 0, 61: -32 });
  // The greatest level of each parameter is the lowest part of the interval: zeros alone.
  const whole = ["0", ...Array(9).fill("3")];
  of(whole, all(3, 68, () => 1e6));
  of(whole, all(3, 68, () => -1e6));
  of(whole, all(3, 68, () => 0));
  return planes;
}

/** Values far outside of every range, which saturate and are caught up with; the coarsest steps; 24000/1001 Hz. */
function wild() {
  const planes = [];
  for (let t = 0; t < 14; t++) {
    const size = t < 7 ? 4e5 : 3000;
    planes.push({ intra: t % 7 === 0, values: all(3, 68, (fap) => wave(fap * 7, t * (1 + (fap % 3)), size)) });
  }
  const masks = ["0", ...Array(9).fill("3")];
  Object.assign(planes[0], { frameRate: [24, 0, 1], quantiser: 31, masks, ranges: [null, null, null, null] });
  Object.assign(planes[7], {
    quantiser: 3,
    masks,
    ranges: [
      Array.from({ length: 66 }, (_, i) => i % 32),
      Array.from({ length: 66 }, (_, i) => (7 * i) % 32),
      null,
      Array.from({ length: 66 }, (_, i) => (5 * i + 1) % 32),
    ],
  });
  return planes;
}

export const clips = { "fba-speech": speech(), "fba-zeros": zeros(), "fba-wild": wild() };
