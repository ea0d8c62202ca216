import { expect, test } from 'vitest';

import type { Errors, Quality } from '../quality';
import { decisive, errorText, firstSentence, reasonsOf, timesText } from './reasons';

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

test('each comparison has its number, its relation to the error, and what it would call the twin', () => {
  const rows = reasonsOf(QUALITY, SCALE).map(({ name, relation, level }) => [name, relation, level]);
  expect(rows).toEqual([
    ['Error on later frames (tracks)', '', null],
    ['Standing still', '6.83 times less', 'good'],
    ['Size of the object', '6.6 % of it', 'poor'],
    ['Spacing of the nodes', '1.66 times less', 'good'],
    ['Constant-bias correction', '1.06 times more', 'fair'],
    ['Error on fitted frames', '2.15 times more', 'fair'],
    ['Springs without bending', '2 times less', null],
  ]);
});

test('comparisons without data are left out', () => {
  expect(reasonsOf(QUALITY, null).map(({ name }) => name)).not.toContain('Size of the object');
  expect(reasonsOf({ scores: [score('bending', 0.001, null)] }, SCALE).map(({ name }) => name)).toEqual([
    'Error on later frames (Chamfer)',
    'Size of the object',
    'Spacing of the nodes',
  ]);
  expect(reasonsOf({ scores: [{ predictor: 'bending', train: NONE, future: NONE }] }, SCALE)).toEqual([]);
});

test('a verdict is due to the comparisons of its level', () => {
  const reasons = reasonsOf(QUALITY, SCALE);
  expect(decisive(reasons, 'poor')).toEqual(['Size of the object']);
  expect(decisive(reasons, 'fair')).toEqual(['Constant-bias correction', 'Error on fitted frames']);
  expect(decisive(reasons, 'good')).toEqual([]);
});

test('an error is named with its measure', () => {
  expect(errorText(QUALITY)).toBe('18.3 mm (tracks)');
  expect(errorText({ scores: [score('bending', 0.001, null)] })).toBe('1 mm (Chamfer)');
  expect(errorText({})).toBe('–');
  expect([timesText(0.001, 0.05), timesText(0.001, 0.001)]).toEqual(['50 times less', 'the same']);
});

test('the first sentence ends before the reasons, not in a number', () => {
  expect(firstSentence('The twin is off by 18.3 mm: 6.84 times nearer.')).toBe('The twin is off by 18.3 mm.');
  expect(firstSentence('The twin was not scored.')).toBe('The twin was not scored.');
  expect(firstSentence('without an end')).toBe('without an end');
});
