// The page Devices: rates of the device of the page at content of known size.
import { axe, openStudio, slide } from './page.mjs';

const unless = (right, fault) => (right ? [] : [fault]);

export const DEVICES = [
  {
    name: 'a device is benchmarked, and its score predicts what it plays',
    async run({ browser, server }) {
      const { context, page, errors } = await openStudio(browser, server.address, { hash: '#devices' });
      await slide(page, 'At most', 1);
      await page.getByRole('button', { name: 'Run all three' }).click();
      await page.waitForFunction(() => document.querySelectorAll('[data-result]').length === 3, undefined, { timeout: 60_000 });
      const results = await page.evaluate(() => [...document.querySelectorAll('[data-result]')].map((out) => JSON.parse(out.dataset.result)));
      const faults = await axe(page);
      await context.close();
      const of = ({ application, score, full_fps, grades, reference }) => {
        const rates = grades.map(({ fps }) => fps);
        // The geometric mean of the rates over those of the reference machine: the grades may have unlike numbers of runs,
        // so only the range is sure.
        const shares = grades.map(({ grade, fps }) => (100 * fps) / reference[grade].fps);
        return [
          ...unless(reference.length === 12, `${application}: ${reference.length} grades`),
          ...unless(rates.length > 0 && rates.every((fps) => fps > 0), `${application}: rates ${rates}`),
          ...unless(score >= Math.min(...shares) * 0.999 && score <= Math.max(...shares) * 1.001, `${application}: a score of ${score} of ${shares}`),
          ...unless(full_fps > 0, `${application}: ${full_fps} of all`),
        ];
      };
      return [...faults, ...errors, ...results.flatMap(of), ...unless(results.map((r) => r.application).join() === 'body,face,crowd', 'another order')];
    },
  },
];
