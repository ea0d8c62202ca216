import { counted } from '../ui/format';

/** Levels of doubt with their words, the least first; reports warn from the last one on (`MASKS_DOUBTFUL`). */
export const LEVELS = [
  { from: 0, word: 'sure', colour: '--good' },
  { from: 0.12, word: 'some doubt', colour: '--warn' },
  { from: 0.25, word: 'doubtful', colour: '--bad' },
] as const;

export type Level = (typeof LEVELS)[number];
/** Share of object and hand in each image of a camera whose label is uncertain, 0..=1; null without an image. */
export type Doubt = readonly (number | null)[];

/** Ranges of frames that are named before the rest is only counted. */
const MOST_RANGES = 3;

/** Level of a doubt; null without an image. */
export function levelOf(doubt: number | null | undefined): Level | null {
  if (doubt === null || doubt === undefined) return null;
  return LEVELS.findLast(({ from }) => doubt >= from) ?? LEVELS[0];
}

/** The doubt of a camera in a sentence without its end. */
export function summary(doubt: Doubt): string {
  const known = doubt.filter((value) => value !== null);
  if (known.length === 0) return 'no images';
  const ranges = rangesOf(doubt, (value) => levelOf(value) === LEVELS[2]);
  const some = doubt.filter((value) => levelOf(value) === LEVELS[1]).length;
  const missing = doubt.length - known.length;
  const named = ranges.slice(0, MOST_RANGES).map(([first, last]) => (first === last ? `${first}` : `${first} to ${last}`));
  const more = ranges.length > MOST_RANGES ? ` and in ${counted(ranges.length - MOST_RANGES, 'more place')}` : '';
  const isOne = ranges.length === 1 && ranges[0]![0] === ranges[0]![1];
  const parts = [
    ranges.length > 0 && `doubtful in ${isOne ? 'frame' : 'frames'} ${named.join(', ')}${more}`,
    some > 0 && `some doubt in ${counted(some, 'frame')}`,
    missing > 0 && `no image in ${counted(missing, 'frame')}`,
  ].filter((part) => part !== false);
  return parts.length === 0 ? 'sure in all frames' : parts.join(', ');
}

/** The middle of the next stretch after a frame that is doubtful in a camera, from the start again; null without one. */
export function nextDoubtful(cameras: readonly Doubt[], frame: number): number | null {
  const most = Math.max(0, ...cameras.map((doubt) => doubt.length));
  const worst = Array.from({ length: most }, (_, t) => Math.max(...cameras.map((doubt) => doubt[t] ?? 0)));
  const ranges = rangesOf(worst, (value) => levelOf(value) === LEVELS[2]);
  const middles = ranges.map(([first, last]) => Math.floor((first + last) / 2));
  return middles.find((middle) => middle > frame) ?? middles[0] ?? null;
}

/** First and last frames of the stretches in which something is so. */
function rangesOf(doubt: Doubt, isSo: (value: number | null) => boolean): [first: number, last: number][] {
  const ranges: [number, number][] = [];
  doubt.forEach((value, frame) => {
    if (!isSo(value)) return;
    const last = ranges.at(-1);
    if (last !== undefined && last[1] === frame - 1) last[1] = frame;
    else ranges.push([frame, frame]);
  });
  return ranges;
}
