import { expect, it } from 'vitest';
import { SplatOrder, byImportance } from './order';

it('orders from far to near', () => {
  const means = new Float32Array([0, 0, 1, 0, 0, 3, 0, 0, 2, 0, 0, 9]);
  const out = new Uint32Array(3);
  new SplatOrder(4).sort(means, Uint32Array.of(0, 1, 2), [0, 0, 1], out);
  expect([...out]).toEqual([1, 2, 0]);
  new SplatOrder(4).sort(means, Uint32Array.of(0, 1, 2), [0, 0, -1], out);
  expect([...out]).toEqual([0, 2, 1]);
});

it('keeps all splats at one depth', () => {
  const out = new Uint32Array(2);
  new SplatOrder(2).sort(new Float32Array(6), Uint32Array.of(1, 0), [1, 0, 0], out);
  expect([...out].sort()).toEqual([0, 1]);
});

it('prefers large and opaque splats', () => {
  const scales = new Float32Array([1, 1, 1, 2, 2, 0.1, 1, 1, 1]);
  expect([...byImportance(new Float32Array([0.5, 0.5, 1]), scales)]).toEqual([1, 2, 0]);
});
