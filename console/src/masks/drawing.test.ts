import { expect, it } from 'vitest';
import { pixelsOf } from './drawing';

it('masks differ by colour and pattern, have edges, and leave the rest clear', () => {
  const columns = 24;
  const labels = new Uint8Array(columns * 12);
  for (let y = 2; y < 10; y += 1) {
    labels.fill(1, y * columns + 2, y * columns + 10);
    labels.fill(2, y * columns + 12, y * columns + 22);
  }
  const pixels = pixelsOf(labels, columns);
  const at = (x: number, y: number): number[] => [...pixels.subarray(4 * (y * columns + x), 4 * (y * columns + x) + 4)];
  expect(at(0, 0)[3]).toBe(0);
  expect(at(2, 5)[3]).toBe(255);
  const opacities = (from: number, to: number): Set<number> =>
    new Set(Array.from({ length: to - from }, (_, i) => at(from + i, 5)[3]!));
  expect(opacities(3, 9).size).toBe(1);
  expect(opacities(13, 21).size).toBe(2);
  expect(at(5, 5).slice(0, 3)).not.toEqual(at(15, 5).slice(0, 3));
});
