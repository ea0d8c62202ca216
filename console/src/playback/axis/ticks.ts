/** Round numbers from 0 to `most`, up to `count` or the first one beyond 0: steps of 1, 2 or 5 times a power of ten. */
export function ticks(most: number, count: number): number[] {
  if (!(most > 0) || !Number.isFinite(most)) return [0];
  const least = most / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(least));
  const steppable = [0.1, 0.2, 0.5, 1, 2, 5, 10].map((factor) => factor * power).filter((each) => each <= most * (1 + 1e-9));
  const step = steppable.find((each) => each >= least * (1 - 1e-9)) ?? steppable.at(-1)!;
  const steps = Math.floor(most / step + 1e-9);
  // Products, not sums, so that rounding does not add up.
  return Array.from({ length: steps + 1 }, (_, i) => Number((i * step).toPrecision(12)));
}
