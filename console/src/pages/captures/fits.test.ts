import { expect, test } from 'vitest';

import { Fits } from './fits';

const FITS = [
  { capture: 'a', error_m: 0.004, measure: 'chamfer' },
  { capture: 'b', error_m: null, measure: null },
  { capture: 'a', error_m: 0.003, measure: 'track' },
  { capture: 'a', error_m: null, measure: null },
];
const BEST = { error_m: 0.003, measure: 'track' };

test('fits are counted by capture, and the best is the one with the least error', () => {
  const fits = new Fits(FITS, true);
  expect(['a', 'b', 'c'].map((capture) => fits.count(capture))).toEqual(['3', '1', '0']);
  expect(['a', 'b', 'c'].map((capture) => fits.best(capture))).toEqual([BEST, null, null]);
});

test('of a part of all fits no number is said', () => {
  const fits = new Fits(FITS, false);
  expect(fits.count('a')).toBe('–');
  expect(fits.best('a')).toEqual(BEST);
});
