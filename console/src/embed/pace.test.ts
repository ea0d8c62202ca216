import { expect, it } from 'vitest';
import { Pace } from './pace';

const DT = 1 / 3000;

/** Pictures at 60 a second on a device where a substep takes so long [ms]; substeps in all. */
function play(pace: Pace, costMs: number, pictures: number): number {
  let sum = 0;
  for (let picture = 0; picture < pictures; picture += 1) {
    const substeps = pace.take(1 / 60, DT);
    if (substeps > 0) pace.took(costMs * substeps, substeps);
    sum += substeps;
  }
  return sum;
}

it('keeps real time where it can, without losing parts of substeps', () => {
  const pace = new Pace();
  play(pace, 0.05, 5);
  expect(play(pace, 0.05, 600) * DT).toBeCloseTo(10, 2);
  expect(pace.speed).toBeGreaterThan(0.99);
  expect(pace.isSlow).toBe(false);
});

it('is slower where it cannot, and leaves time for drawing', () => {
  const pace = new Pace();
  play(pace, 0.5, 10);
  const substeps = play(pace, 0.5, 300);
  expect((substeps * 0.5) / (300 * (1000 / 60))).toBeLessThan(0.52);
  expect(pace.isSlow).toBe(true);
  expect(pace.speed).toBeCloseTo((substeps * DT) / 5, 1);
  play(pace, 0.05, 120);
  expect(pace.isSlow).toBe(false);
});

it('does not catch up with a time in which nothing was drawn', () => {
  const pace = new Pace();
  play(pace, 0.01, 10);
  expect(pace.take(60, DT) * DT).toBeLessThan(0.11);
});

it('does not slow down for a single picture that took long', () => {
  const pace = new Pace();
  play(pace, 0.05, 10);
  pace.took(500, 50);
  expect(play(pace, 0.05, 60) * DT).toBeCloseTo(1, 1);
});
