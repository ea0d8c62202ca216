import { describe, expect, it } from 'vitest';
import { Material } from './strain';

/** Three nodes in a row, 1 m apart, and a spring to a control point. */
const LINE = {
  rest: new Float32Array([0, 0, 0, 1, 0, 0, 2, 0, 0]),
  springs: Uint32Array.of(0, 1, 1, 2, 2, 3),
  restLengths: Float32Array.of(1, 1, 0.001),
};

/** Nodes of which the middle one and the last one lie there. */
function nodes(middle: number, last: number): Float32Array {
  return new Float32Array([0, 0, 0, middle, 0, 0, last, 0, 0]);
}

describe('strain beyond a recording', () => {
  const material = new Material(LINE);

  it('is compared with the largest of any spring, without single frames', () => {
    // The first spring is stretched by up to 10 %, in one frame of 400 by 50 %; the second compressed by up to 4 %.
    const frames = Array.from({ length: 400 }, (_, t) => {
      const share = t / 399;
      const middle = t === 7 ? 1.5 : 1 + 0.1 * share;
      return nodes(middle, middle + 1 - 0.04 * share);
    });
    const { stretched, compressed } = material.recorded(frames);
    expect(stretched).toBeCloseTo(0.1, 3);
    expect(compressed).toBeCloseTo(0.04, 3);
    expect(material.recorded([])).toEqual({ stretched: 0, compressed: 0 });
  });

  it('says how many times, which way, and where', () => {
    const range = { stretched: 0.1, compressed: 0.05 };
    const within = material.compare(nodes(1.09, 2.05), range);
    expect(within.times).toBeCloseTo(0.9, 3);
    expect([...within.nodes]).toEqual([0, 0, 0]);
    const pulled = material.compare(nodes(1, 2.15), range);
    expect([pulled.times.toFixed(3), pulled.way]).toEqual(['1.500', 'stretched']);
    expect(Array.from(pulled.nodes, (x) => Number(x.toFixed(3)))).toEqual([0, 0.5, 0.5]);
    const pushed = material.compare(nodes(0.8, 1.8), range);
    expect([pushed.times.toFixed(3), pushed.way]).toEqual(['4.000', 'compressed']);
    expect([...pushed.nodes]).toEqual([1, 1, 0]);
  });

  it('does not count what is less than two per cent', () => {
    expect(material.compare(nodes(1.01, 2), { stretched: 0, compressed: 0 }).times).toBeCloseTo(0.5, 3);
  });
});
