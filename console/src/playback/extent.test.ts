import { describe, expect, it } from 'vitest';
import { loadExtent, near, withoutStrays } from './extent';
import { Motion } from './file/motion';
import { int16, sequence } from './testing';

describe('the extent of a sequence', () => {
  it('has the seen points of all frames, and the control points', async () => {
    const { motion } = sequence();
    // Two points in two frames, the second one seen in the second frame alone.
    const data = new Uint8Array([...int16(0, 0, 0, 9, 9, 9, 100, 0, 0, 0, 100, 0), 0b01, 0b11, ...int16(0, 0, 5, 0, 0, 6)]);
    const read = ([first, length]: readonly [number, number]) => Promise.resolve(data.slice(first, first + length));
    const extent = await loadExtent(new Motion(motion, 2, read), new Float32Array([7, 7, 7, 8, 8, 8]));
    const path = Array.from(extent.path, (x) => Number(x.toFixed(3)));
    expect(path).toEqual([1, 0, 0, 1.1, 0, 0, 1, 0.1, 0, 7, 7, 7, 8, 8, 8]);
    expect(extent.first).toHaveLength(3);
  });

  it('leaves out what is far from the rest, and not the ends of a line', () => {
    const line = Array.from({ length: 50 }, (_, i) => [0.01 * i, 0, 0]).flat();
    expect(withoutStrays(Float32Array.from(line))).toHaveLength(150);
    expect(withoutStrays(Float32Array.from([...line, 3, 3, 3]))).toHaveLength(150);
    expect(withoutStrays(new Float32Array(0))).toHaveLength(0);
  });

  it('goes a little beyond what was observed, not as far as a prediction that fails', () => {
    const observed = new Float32Array([0, 0, 0, 1, 1, 1, NaN, NaN, NaN]);
    expect([...near(new Float32Array([1.2, 0, 0, 0, 0, -9, NaN, 0, 0]), observed)]).toEqual([expect.closeTo(1.2), 0, 0]);
  });
});
