import { expect, it } from 'vitest';
import { jobs, parseMetrics, total } from './metrics';

it('reads values by name and labels', () => {
  const metrics = parseMetrics(
    '# HELP bendtwin_fits Fits\n# TYPE bendtwin_fits gauge\nbendtwin_fits{state="queued"} 2\n' +
      'bendtwin_fits{state="failed"} 1\n\nbendtwin_workers 1\nbendtwin_seconds NaN\nnonsense\n',
  );
  expect(metrics.get('bendtwin_workers')).toBe(1);
  expect(metrics.has('bendtwin_seconds')).toBe(false);
  expect(total(jobs(metrics, 'fits'))).toBe(3);
  expect(total(jobs(metrics, 'ingests'))).toBe(0);
});
