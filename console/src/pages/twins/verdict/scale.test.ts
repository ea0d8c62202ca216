import { expect, test } from 'vitest';

import { scaleOf } from './scale';

/** Nodes in a row, a centimetre apart. */
const ROW = Float32Array.from({ length: 3 * 9 }, (_, i) => (i % 3 === 0 ? i / 300 : 0));

test('the size is the diagonal of the box around the nodes', () => {
  expect(scaleOf(new Float32Array([0, 0, 0, 0.3, 0.4, 0, 0.1, 0.1, 1.2]), []).size_m).toBeCloseTo(1.3, 6);
  expect(scaleOf(new Float32Array(), [])).toEqual({ size_m: 0, spacing_m: 0 });
});

test('the spacing is the distance to the sixth neighbour, or along rods', () => {
  // From the middle of the row outwards the sixth neighbour is 3, 4, 5, 6 and 6 centimetres away.
  const expected = (0.03 + 2 * (0.03 + 0.04 + 0.05 + 0.06)) / 9;
  expect(scaleOf(ROW, []).spacing_m).toBeCloseTo(expected, 6);
  expect(scaleOf(ROW, [new Uint32Array([0, 2, 4]), new Uint32Array([5, 6])]).spacing_m).toBeCloseTo(0.05 / 3, 6);
  expect(scaleOf(ROW.subarray(0, 6), []).spacing_m).toBeCloseTo(0.01, 6);
});
