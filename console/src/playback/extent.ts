import type { Frame, Motion } from './file/motion';

/** Bytes of points up to which all of them are loaded, and the frames that are loaded of larger ones. */
const MOST_BYTES = 4 << 20;
const SOME_FRAMES = 16;
/** Points that are this many times farther from the middle than most are strays, which were tracked wrongly. */
const STRAY = 2.5;
const MOST = 0.8;
/** Distance from what was observed at which a prediction is left out, as a share of the extent of that. */
const FAR = 0.3;
/** About how many points show where things are. */
const POINTS = 20_000;

/** Where the points of a sequence are [m]. */
export interface Extent {
  /** The object's in the first frame, shape [M, 3]. */
  readonly first: Float32Array;
  /** Those of object and hands over all frames, shape [K, 3]. */
  readonly path: Float32Array;
}

/** Where things are in a sequence, by all or some of its frames; `controls` [m] have shape [T, C, 3]. */
export async function loadExtent(motion: Motion, controls: Float32Array): Promise<Extent> {
  const { frameCount, head } = motion;
  const frames = evenly(frameCount, head.points[1] <= MOST_BYTES ? frameCount : SOME_FRAMES);
  await Promise.all(frames.map((frame) => motion.load(frame)));
  const points = frames.flatMap((frame) => motion.frame(frame) ?? []).map((frame) => withoutStrays(visiblePoints(frame).points));
  const each = thinned(joined(points), POINTS);
  return { first: points[0] ?? new Float32Array(0), path: joined([each, thinned(controls, POINTS / 4)]) };
}

/** Points that a camera saw in a frame. */
export interface Seen {
  /** [m], shape [M, 3] */
  readonly points: Float32Array;
  /** Their places among all points, shape [M]. */
  readonly indices: readonly number[];
}

/** The points of a frame that a camera saw. */
export function visiblePoints({ points, visible }: Frame): Seen {
  const indices: number[] = [];
  visible.forEach((flag, i) => {
    if (flag === 1 && !Number.isNaN(points[3 * i]!)) indices.push(i);
  });
  const kept = new Float32Array(3 * indices.length);
  indices.forEach((index, i) => kept.set(points.subarray(3 * index, 3 * index + 3), 3 * i));
  return { points: kept, indices };
}

/** Up to `count` numbers from 0 to `all - 1`, both included, evenly apart. */
function evenly(all: number, count: number): number[] {
  const some = Math.min(all, count);
  return Array.from({ length: some }, (_, i) => Math.round((i * (all - 1)) / Math.max(some - 1, 1)));
}

/** Points of one frame, shape [M, 3], without those that are far from the others. */
export function withoutStrays(points: Float32Array): Float32Array {
  const count = points.length / 3;
  if (count === 0) return points;
  const middle = [0, 1, 2].map((axis) => points.filter((_, i) => i % 3 === axis).sort()[count >> 1]!);
  const distances = Float32Array.from({ length: count }, (_, m) => {
    return Math.hypot(...middle.map((x, axis) => points[3 * m + axis]! - x));
  });
  const bound = STRAY * distances.slice().sort()[Math.floor(MOST * (count - 1))]!;
  return points.filter((_, i) => distances[Math.floor(i / 3)]! <= bound);
}

/** About `count` of some points, shape [M, 3], evenly chosen. */
function thinned(points: Float32Array, count: number): Float32Array {
  const step = Math.max(Math.round(points.length / 3 / count), 1);
  const kept = new Float32Array(3 * Math.ceil(points.length / 3 / step));
  for (let k = 0; 3 * k < kept.length; k += 1) kept.set(points.subarray(3 * step * k, 3 * step * k + 3), 3 * k);
  return kept;
}

/** Some of points [m], shape [M, 3], without those that are far from all of `others`: a prediction may fail. */
export function near(points: Float32Array, others: Float32Array): Float32Array {
  const bounds = [0, 1, 2].map((axis) => {
    const values = others.filter((x, i) => i % 3 === axis && Number.isFinite(x));
    const low = values.reduce((least, x) => Math.min(least, x), Infinity);
    return { low, high: values.reduce((most, x) => Math.max(most, x), -Infinity) };
  });
  const margin = FAR * Math.max(...bounds.map(({ low, high }) => high - low));
  const some = thinned(points, POINTS / 4);
  const isNear = (m: number): boolean => bounds.every(({ low, high }, axis) => {
    const x = some[3 * m + axis]!;
    return x >= low - margin && x <= high + margin;
  });
  return some.filter((_, i) => isNear(Math.floor(i / 3)));
}

/** Arrays one behind the other. */
export function joined(arrays: readonly Float32Array[]): Float32Array {
  const all = new Float32Array(arrays.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const array of arrays) {
    all.set(array, at);
    at += array.length;
  }
  return all;
}
