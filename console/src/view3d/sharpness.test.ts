import { expect, it } from 'vitest';
import { Sharpness } from './sharpness';

function frames(sharpness: Sharpness, count: number, span: number): void {
  for (let i = 0; i < count; i += 1) sharpness.next(1000 + i * span, true);
}

it('draws fewer pixels while a slow machine shows motion, and all of them afterwards', () => {
  const sharpness = new Sharpness();
  frames(sharpness, 30, 16);
  expect([sharpness.isFull, sharpness.ratio(1)]).toEqual([true, 1]);
  frames(sharpness, 30, 50);
  expect([sharpness.isFull, sharpness.ratio(1)]).toEqual([false, 0.5]);
  expect(sharpness.next(9000, false)).toBe(true);
  expect([sharpness.isFull, sharpness.next(9016, false)]).toEqual([true, false]);
});

it('is bounded by the screen\'s resolution', () => {
  expect([new Sharpness().ratio(3), new Sharpness().ratio(0.1)]).toEqual([2, 0.5]);
});
