import { count, percent } from '../../../ui/format';
import type { CameraReport, Report } from './report';

/** Most cameras with separate lines, and with a band. */
const MOST_LINES = 6;
const MOST_BANDS = 16;
/** Levels beyond which the report warns: the share of the object with depth, and the distance of the hand [mm]. */
const GOOD_COVERAGE = 0.6;
const FAR_MM = 60;

/** A line over frames, null where nothing was measured. */
export interface Line {
  readonly name: string;
  readonly values: readonly (number | null)[];
}

/** A figure over frames, a line for each camera or quantity, from 0 up. */
export interface Timeline {
  readonly title: string;
  readonly meaning: string;
  readonly lines: readonly Line[];
  /** Upper end of the axis; null: the largest value. */
  readonly top: number | null;
  /** A level that the report warns beyond; null: none. */
  readonly limit: number | null;
  readonly word: (value: number) => string;
}

/** What is wrong with a frame of a camera, from the least to the worst; `fine` is nothing. */
export const FRAME_STATES = ['fine', 'late', 'mask jumps', 'repeated', 'mask empty', 'missing'] as const;
export type FrameState = (typeof FRAME_STATES)[number];

/** The frames of a camera with what is wrong with each. */
export interface Band {
  readonly name: string;
  readonly states: readonly FrameState[];
}

/** The frames of each camera; of more than a few cameras the first. */
export function bandsOf({ cameras, frame_count }: Report): Band[] {
  return cameras.slice(0, MOST_BANDS).map((camera) => {
    const states: FrameState[] = Array.from({ length: frame_count }, () => 'fine');
    const lists: [FrameState, readonly number[] | undefined][] = [
      ['late', camera.late_frames],
      ['mask jumps', camera.mask_jumps],
      ['repeated', camera.repeated_frames],
      ['mask empty', camera.empty_masks],
      ['missing', camera.missing_frames],
    ];
    // From the least to the worst: the last one stays.
    for (const [state, frames] of lists) for (const frame of frames ?? []) if (frame in states) states[frame] = state;
    return { name: camera.name, states };
  });
}

/** The figures over frames that a report has. */
export function timelinesOf({ cameras, observed, scene, frame_count }: Report): Timeline[] {
  if (frame_count < 2) return [];
  const each = (values: (camera: CameraReport) => readonly (number | null)[] | undefined): Line[] =>
    cameras.slice(0, MOST_LINES).map((camera) => ({ name: camera.name, values: values(camera) ?? [] }));
  const number = (value: number): string => count(Math.round(value));
  const seen: Line[] = [
    { name: 'seen', values: observed?.visible ?? [] },
    { name: 'motion trusted', values: observed?.motion_valid ?? [] },
  ];
  const gaps = (scene?.gap_m ?? []).map((gap) => (gap === null ? null : 1000 * gap));
  const all: Timeline[] = [
    {
      title: 'Depth coverage',
      meaning: 'share of the object with depth',
      lines: each(({ coverage }) => coverage),
      top: 1,
      limit: GOOD_COVERAGE,
      word: percent,
    },
    {
      title: 'Visible area',
      meaning: 'pixels of the object',
      lines: each(({ object_px }) => object_px),
      top: null,
      limit: null,
      word: number,
    },
    {
      title: 'Tracks in space',
      meaning: 'visible, on a mask, with depth',
      lines: each(({ tracks }) => tracks?.liftable),
      top: null,
      limit: null,
      word: number,
    },
    {
      title: 'Tracked points',
      meaning: 'seen in a frame',
      lines: seen,
      top: observed?.point_count ?? null,
      limit: null,
      word: number,
    },
    {
      title: 'Distance of the hand',
      meaning: 'nearest to the object',
      lines: [{ name: 'nearest', values: gaps }],
      top: null,
      limit: FAR_MM,
      word: (mm) => `${mm.toFixed(mm < 10 ? 1 : 0)} mm`,
    },
  ];
  return all.flatMap((timeline) => {
    const lines = timeline.lines.filter(({ values }) => values.some((value) => value !== null));
    return lines.length > 0 ? [{ ...timeline, lines }] : [];
  });
}

/** A figure in words, for those who do not see it: the range of each line, and where it is lowest. */
export function summary({ title, meaning, lines, word }: Timeline): string {
  const ranges = lines.map(({ name, values }) => {
    const known = values.flatMap((value, frame) => (value === null ? [] : [{ value, frame }]));
    const [first] = known;
    if (first === undefined) return `${name}: nothing`;
    const low = known.reduce((a, b) => (b.value < a.value ? b : a), first);
    const high = known.reduce((a, b) => (b.value > a.value ? b : a), first);
    return `${name}: ${word(low.value)} (frame ${low.frame}) to ${word(high.value)} (frame ${high.frame})`;
  });
  return `${title}, ${meaning}. ${ranges.join('; ')}.`;
}

/** The bands in words: what is wrong with how many frames of each camera. */
export function bandsSummary(bands: readonly Band[]): string {
  const parts = bands.map(({ name, states }) => {
    const counts = FRAME_STATES.slice(1).map((state) => [state, states.filter((own) => own === state).length] as const);
    const faults = counts.filter(([, number]) => number > 0).map(([state, number]) => `${number} ${state}`);
    return `${name}: ${faults.length > 0 ? faults.join(', ') : 'all fine'}`;
  });
  return `Frames of each camera. ${parts.join('; ')}.`;
}
