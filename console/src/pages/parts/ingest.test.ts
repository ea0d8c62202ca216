import type { Capture } from '@bendtwin/client';
import { expect, it } from 'vitest';
import { changed, keptSettings } from './ingest';

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

it('settings that are typed change those that are kept one by one', () => {
  const kept = { strokes: [1], calibration: { correct: true } };
  const capture = { ingest: { settings: { ...kept, spacing_m: 0.004 } } } as unknown as Capture;
  expect(changed(keptSettings(capture), { calibration: { ground: 'detected' } })).toEqual({
    ...kept,
    calibration: { correct: true, ground: 'detected' },
  });
});
