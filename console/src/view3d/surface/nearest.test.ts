import { describe, expect, it } from 'vitest';
import { Nearest } from './nearest';

/** Numbers in 0..1 that are the same in every run. */
function numbers(count: number, seed: number): Float32Array {
  let state = seed;
  return Float32Array.from({ length: count }, () => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state / 2147483648;
  });
}

describe('the nearest point', () => {
  it('is the one that a search through all finds', () => {
    const points = numbers(900, 1);
    const others = numbers(300, 2).map((x) => 3 * x - 1);
    for (const reach of [0.01, 0.1, 5]) {
      const nearest = new Nearest(points, reach);
      for (let i = 0; i < 100; i += 1) {
        let best = Infinity;
        for (let m = 0; m < 300; m += 1) {
          best = Math.min(best, Math.hypot(...[0, 1, 2].map((a) => points[3 * m + a]! - others[3 * i + a]!)));
        }
        expect(nearest.distance(others, i)).toBeCloseTo(best, 5);
        const found = nearest.index(others, i)!;
        const apart = [0, 1, 2].map((a) => points[3 * found + a]! - others[3 * i + a]!);
        expect(Math.hypot(...apart)).toBeCloseTo(best, 5);
      }
    }
  });

  it('is NaN for unknown points, and without candidates', () => {
    expect(new Nearest(numbers(30, 1), 0.1).distance(new Float32Array([NaN, NaN, NaN]), 0)).toBeNaN();
    expect(new Nearest(new Float32Array(0), 0.1).distance(new Float32Array(3), 0)).toBeNaN();
  });
});
