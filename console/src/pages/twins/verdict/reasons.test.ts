import { expect, test } from 'vitest';

import type { Errors, Quality } from '../quality';
import { adviceOf } from './advice';
import { decisive, errorText, reasonsOf, shareText } from './reasons';

const NONE: Errors = { chamfer_l1_m: null, chamfer_l2_m: null, track_m: null, coordinate_m: null };

function score(predictor: string, train: number | null, future: number | null) {
  return { predictor, train: { ...NONE, track_m: train }, future: { ...NONE, track_m: future, chamfer_l2_m: 0.001 } };
}

const QUALITY: Quality = {
  scores: [
    score('bending', 0.0085, 0.0183),
    score('standing_still', 0.03, 0.125),
    score('last_residual', null, 0.0172),
    score('axial', 0.02, 0.0366),
  ],
};
const SCALE = { size_m: 0.277, spacing_m: 0.0303 };

test('each comparison has its number, its measure, the error as a share of it, and what it would call the twin', () => {
  const rows = reasonsOf(QUALITY, SCALE).map(({ name, measure, share, level }) => [
    name,
    measure,
    share === null ? '' : shareText(share),
    level,
  ]);
  expect(rows).toEqual([
    ['Error on later frames', 'tracks', '', null],
    ['Standing still', 'tracks', '14.6 %', 'good'],
    ['Size of the object', 'length', '6.6 %', 'poor'],
    ['Spacing of the nodes', 'length', '60.4 %', 'good'],
    ['Constant-bias correction', 'tracks', '106 %', 'fair'],
    ['Error on fitted frames', 'tracks', '215 %', 'fair'],
    ['Springs without bending', 'tracks', '50 %', null],
  ]);
});

test('comparisons without data are left out', () => {
  expect(reasonsOf(QUALITY, null).map(({ name }) => name)).not.toContain('Size of the object');
  expect(reasonsOf({ scores: [score('bending', 0.001, null)] }, SCALE).map(({ name }) => name)).toEqual([
    'Error on later frames',
    'Size of the object',
    'Spacing of the nodes',
  ]);
  expect(reasonsOf({ scores: [{ predictor: 'bending', train: NONE, future: NONE }] }, SCALE)).toEqual([]);
});

test('a verdict is due to the comparisons of its level', () => {
  const reasons = reasonsOf(QUALITY, SCALE);
  const due = (level: string): string[] => decisive(reasons, level).map(({ of }) => of);
  expect(due('poor')).toEqual(['size']);
  expect(due('fair')).toEqual(['bias', 'train']);
  expect(due('good')).toEqual([]);
});

test('an error is named with its measure', () => {
  expect(errorText(QUALITY)).toBe('18.3 mm (tracks)');
  expect(errorText({ scores: [score('bending', 0.001, null)] })).toBe('1 mm (Chamfer)');
  expect(errorText({})).toBe('–');
});

test('advice is by the first comparison of the level, and none where they do not explain it', () => {
  const reasons = reasonsOf(QUALITY, SCALE);
  expect(adviceOf('poor', reasons)?.steps).toEqual(['report', 'starts', 'upload']);
  const without = (of: string) => reasons.filter((reason) => reason.of !== of);
  // Without its size the twin is fair by its lasting error alone.
  expect(adviceOf('fair', without('size'))?.text).toContain('Its error lasts');
  expect(adviceOf('poor', without('size'))).toBeNull();
  expect(adviceOf('unknown', [])?.steps).toContain('evaluate');
  const fair = reasonsOf({ scores: [score('bending', 0.001, 0.012)] }, SCALE);
  expect(adviceOf('fair', fair)?.steps).toEqual(['finer']);
  const coarse = reasonsOf({ scores: [score('bending', 0.001, 0.012)] }, { ...SCALE, spacing_m: 0.01 });
  expect(adviceOf('fair', coarse)?.text).toContain('more nodes hardly');
  expect(adviceOf('good', reasonsOf({ scores: [score('bending', 0.001, 0.002)] }, SCALE))?.text).toContain('Use it');
});
