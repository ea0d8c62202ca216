import { expect, it } from 'vitest';
import { ticks } from './ticks';

it('are round, and about as many as there is room for', () => {
  expect(ticks(0.63, 4)).toEqual([0, 0.2, 0.4, 0.6]);
  expect(ticks(10, 5)).toEqual([0, 2, 4, 6, 8, 10]);
  expect(ticks(0.3, 3)).toEqual([0, 0.1, 0.2, 0.3]);
  expect(ticks(47, 3)).toEqual([0, 20, 40]);
  expect(ticks(0.42, 1)).toEqual([0, 0.2, 0.4]);
  expect(ticks(0, 3)).toEqual([0]);
  expect(ticks(NaN, 3)).toEqual([0]);
});
