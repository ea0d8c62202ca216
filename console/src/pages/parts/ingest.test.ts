import { expect, it } from 'vitest';
import { changed } from './ingest';

it('settings of an ingest are changed one by one', () => {
  const settings = { until: 'points', strokes: [1, 2], calibration: { board: { columns: 7 }, correct: false, ground: 'recorded' } };
  expect(changed(settings, { calibration: { correct: true } })).toEqual({
    ...settings,
    calibration: { ...settings.calibration, correct: true },
  });
  expect(changed(settings, { until: 'masks', strokes: [] })).toEqual({ ...settings, until: 'masks', strokes: [] });
  expect(changed({}, { calibration: { board: null } })).toEqual({ calibration: { board: null } });
  expect(settings.calibration.correct).toBe(false);
});
