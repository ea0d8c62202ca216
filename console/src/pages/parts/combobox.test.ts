import { expect, test } from 'vitest';

import { nextIndex } from './combobox';

test('arrows go around the options', () => {
  expect([-1, 0, 2].map((index) => nextIndex(index, 3, 1))).toEqual([0, 1, 0]);
  expect([-1, 0, 2].map((index) => nextIndex(index, 3, -1))).toEqual([2, 2, 1]);
  expect(nextIndex(0, 1, 1)).toBe(0);
});
