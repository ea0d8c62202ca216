import type { MotionHead } from '../file/head';

/** Speed of a hand in each frame [m/s], shape [T]; null where it is not known. */
export interface HandSpeed {
  readonly label: string;
  readonly values: readonly (number | null)[];
}

/** Hands whose speeds are drawn: more lines could not be distinguished. */
const MOST_HANDS = 3;

/**
 * Speeds of hands: how far the mean of a hand's control points moves from the frame before to the frame
 * after, over the time between them. `controls` [m] have shape [T, C, 3].
 */
export function handSpeeds(
  controls: Float32Array,
  { control_count: count, control_hands: hands = [] }: MotionHead,
  fps: number,
): HandSpeed[] {
  const frames = count === 0 ? 0 : controls.length / (3 * count);
  const known = hands.length === count ? hands : new Array<number>(count).fill(0);
  const all = [...new Set(known)].sort((a, b) => a - b).slice(0, MOST_HANDS);
  return all.map((hand, index) => {
    const own = known.flatMap((other, c) => (other === hand ? [c] : []));
    const values = Array.from({ length: frames }, (_, frame) => {
      const [from, to] = [Math.max(frame - 1, 0), Math.min(frame + 1, frames - 1)];
      const way = wayBetween(controls, own.map((c) => [3 * (from * count + c), 3 * (to * count + c)]));
      return way === null || to === from ? null : (way * fps) / (to - from);
    });
    return { label: all.length === 1 ? 'Hand' : `Hand ${index + 1}`, values };
  });
}

/** Length of the mean way of points that are known at both ends [m]. */
function wayBetween(controls: Float32Array, pairs: readonly (readonly number[])[]): number | null {
  const sum = [0, 0, 0];
  let count = 0;
  for (const [from, to] of pairs as readonly (readonly [number, number])[]) {
    const way = sum.map((_, axis) => controls[to + axis]! - controls[from + axis]!);
    if (way.some(Number.isNaN)) continue;
    way.forEach((x, axis) => (sum[axis]! += x));
    count += 1;
  }
  return count === 0 ? null : Math.hypot(...sum) / count;
}
