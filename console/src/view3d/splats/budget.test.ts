import { expect, it } from 'vitest';
import { SplatBudget } from './budget';

function after(gap: number, pictures: number, count = 50_000): number {
  const budget = new SplatBudget(count);
  let limit = count;
  for (let k = 0; k < pictures; k += 1) limit = budget.next(k * gap);
  return limit;
}

it('keeps all splats while pictures come often enough or rarely for other reasons', () => {
  expect(after(16, 1000)).toBe(50_000);
  expect(after(500, 1000)).toBe(50_000);
});

it('draws fewer where pictures are slow, and some at least', () => {
  expect(after(50, 20)).toBe(37_500);
  expect(after(50, 2000)).toBe(1000);
  expect(after(50, 2000, 600)).toBe(600);
});
