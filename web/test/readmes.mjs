// The examples of the READMEs, run as they stand.
import { readFile } from 'node:fs/promises';

/** Returns an example of a README, the first if not told. */
export async function example(name, index = 0) {
  const text = await readFile(new URL(`../packages/${name}/README.md`, import.meta.url), 'utf8');
  return [...text.matchAll(/```js\n(.*?)```/gs)][index][1];
}

const lines = (code) => code.split('\n').filter((line) => line.trim() !== '').length;

export const READMES = [
  {
    name: 'readme three',
    call: ['readmePicture', [await example('three')]],
    async check({ png, colors }, save) {
      await save('page', png);
      return colors > 100 ? [] : [`the picture has ${colors} colours`];
    },
  },
  {
    name: 'readme core',
    call: ['readmeLines', [await example('core')]],
    check: (printed) =>
      printed.length >= 3 && /^[1-9]\d* of 100 characters are seen$/.test(printed[0]) ? [] : [printed.join('; ')],
  },
].map((test) => ({
  ...test,
  check: async (...args) => [
    ...(lines(test.call[1][0]) > 26 ? [`the example has ${lines(test.call[1][0])} lines`] : []),
    ...(await test.check(...args)),
  ],
}));
