import { expect, it } from 'vitest';
import { layoutOf } from './compose';

it('lays panels beside each other, in even sizes', () => {
  const { width, height, pictures, boxes } = layoutOf([4 / 3, 1]);
  expect(boxes).toEqual([{ x: 0, width: 720 }, { x: 724, width: 540 }]);
  expect([width, pictures, height % 2]).toEqual([1264, 540, 0]);
});

it('makes wide ones smaller', () => {
  const { width, pictures, boxes } = layoutOf([3, 3]);
  expect(width).toBeLessThanOrEqual(1604);
  expect(boxes[1]!.width / pictures).toBeCloseTo(3, 1);
  expect([width % 2, pictures % 2]).toEqual([0, 0]);
});
