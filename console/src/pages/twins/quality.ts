import type { Twin } from '@bendtwin/client';
import type { Child } from '../../ui/dom';
import { millimetres } from '../../ui/format';
import { errorCell, measureWord } from '../parts/error';

/** Errors of a prediction [m]; null where they cannot be measured. */
export interface Errors {
  readonly chamfer_l1_m: number | null;
  readonly chamfer_l2_m: number | null;
  readonly track_m: number | null;
  readonly coordinate_m: number | null;
  readonly padded_rms_m?: number | null;
}

/** Likeness of renderings to what cameras saw; null where it cannot be measured. */
export interface Likeness {
  readonly iou: number | null;
  readonly psnr_db: number | null;
  readonly ssim: number | null;
  readonly flip: number | null;
  readonly lpips?: number | null;
}

/** Likeness of a prediction's renderings, over all cameras that were not held out and in each. */
export interface Rendered {
  readonly gaussians: number;
  readonly train: Likeness;
  readonly future: Likeness;
  readonly cameras: readonly {
    readonly name: string;
    readonly held_out?: boolean;
    readonly train: Likeness;
    readonly future: Likeness;
  }[];
}

export interface Score {
  readonly predictor: string;
  readonly train: Errors;
  readonly future: Errors;
  readonly at_nodes?: { readonly train: Errors; readonly future: Errors };
  readonly rendered?: Rendered;
}

/** A row of the table of renderings. */
export interface RenderedRow {
  readonly text: string;
  readonly train: Likeness;
  readonly future: Likeness;
}

/** Rows of renderings: each prediction over all cameras, then the first one's by camera. */
export function renderedRowsOf({ scores = [] }: Quality): RenderedRow[] {
  const rendered = scores.filter((score) => score.rendered !== undefined);
  const whole = rendered.flatMap(({ predictor, rendered: own }, index) =>
    own === undefined ? [] : [{ text: predictorText(predictor, index === 0), train: own.train, future: own.future }],
  );
  const cameras = (rendered[0]?.rendered?.cameras ?? []).map(({ name, held_out, train, future }) => ({
    text: `camera ${name}${held_out === true ? ' (held out)' : ''}`,
    train,
    future,
  }));
  return [...whole, ...cameras];
}

/** A twin in words. */
export interface Assessment {
  readonly level: string;
  readonly why: string;
  readonly next: string;
}

/** The quality table of a twin (docs/formats/twin.md, `quality`). */
export interface Quality {
  readonly scores?: readonly Score[];
  readonly warnings?: readonly string[];
  readonly assessment?: Assessment;
  readonly choice?: {
    readonly start: number;
    readonly held_back_frames: number;
    readonly losses: readonly (number | null)[];
  };
  readonly recordings?: readonly Recording[];
  readonly spread?: Spread;
  readonly identifiability?: Identifiability;
  readonly fast?: {
    readonly substeps: number;
    readonly mean_deviation_m: number;
    readonly max_deviation_m: number;
    readonly mean_travel_m: number;
    readonly frames: number;
  };
}

/** Distances between the predictions of several fits of one capture, beside the twin's error. */
export interface Spread {
  /** The twin and its members. */
  readonly fits: number;
  readonly mean_m: number;
  readonly error_m: number;
  /** Share of the points whose error is at most twice what the spread lets expect. */
  readonly within: number;
  /** Rank correlation of spread and error, -1 to 1. */
  readonly rank_correlation?: number | null;
}

/** What the recordings leave open of a twin: groups of parameters, and motions in metres. */
export interface Identifiability {
  /** The report in sentences. */
  readonly summary: readonly string[];
  readonly regions: readonly { readonly name: string }[];
  readonly groups: readonly OpenGroup[];
  readonly motions: readonly { readonly motion: string; readonly sd_m: number; readonly shares: readonly number[] }[];
  readonly next: readonly { readonly motion: string; readonly action: string; readonly sd_m: number }[];
}

/** Parameters that change together. */
export interface OpenGroup {
  readonly quantity: string;
  readonly region?: number;
  readonly hand?: number;
  /** Standard deviation that the recordings leave, over the one before them. */
  readonly relative_sd: number;
  readonly certainty: string;
}

export interface Recording {
  readonly name: string;
  readonly train: Errors;
  readonly future: Errors;
  readonly registered?: { readonly median_mm: number; readonly p95_mm: number; readonly explained: number };
}

export type Measure = keyof Errors;

const MEASURES: readonly (readonly [Measure, string])[] = [
  ['track_m', measureWord('track')],
  ['coordinate_m', measureWord('coordinate')],
  ['chamfer_l2_m', measureWord('chamfer')],
  ['chamfer_l1_m', 'Chamfer L1'],
  ['padded_rms_m', 'padded RMS'],
];

const PREDICTORS: Record<string, string> = {
  bending: 'This twin',
  axial: 'Axial springs alone',
  mean_of_fits: 'Mean of its fits',
  standing_still: 'Standing still',
  last_residual: 'Constant-bias correction',
  clamp_interpolation: 'Interpolation between the clamps',
};

/**
 * A predictor in words; with the number of fits in the mean, if that is known. A twin that was
 * fitted without bending has its first score as axial.
 */
export function predictorText(predictor: string, isFirst: boolean, fits?: number): string {
  if (isFirst && predictor === 'axial') return 'This twin, axial springs alone';
  if (predictor === 'mean_of_fits' && fits !== undefined) return `Mean of ${fits} fits`;
  return PREDICTORS[predictor] ?? predictor;
}

/** A row of the table: errors of training and future frames by measure. */
export interface Row {
  readonly text: string;
  readonly train: Errors;
  readonly future: Errors;
}

/** All rows: predictors, and below each what it has at the nodes in place of the skin. */
export function rowsOf({ scores = [], spread }: Quality): Row[] {
  return scores.flatMap(({ predictor, train, future, at_nodes }, index) => {
    const text = predictorText(predictor, index === 0, spread?.fits);
    return [
      { text, train, future },
      ...(at_nodes === undefined ? [] : [{ text: `${text}, at its nodes`, ...at_nodes }]),
    ];
  });
}

/** The measures that anything has in a table, with their words. */
export function measuresOf(rows: readonly Row[]): (readonly [Measure, string])[] {
  return MEASURES.filter(([measure]) =>
    rows.some(({ train, future }) => isNumber(train[measure]) || isNumber(future[measure])),
  );
}

/** An error, its measure and that in a word. */
export interface Headline {
  readonly measure: Measure;
  readonly word: string;
  readonly error_m: number;
}

/**
 * A twin's error with its measure, by the rule of `Twin.error_m` (proto/bendtwin/v1/twin.proto): that on later frames,
 * or that on fitted ones.
 */
export function headlineOf({ scores }: Quality, part: 'future' | 'train' = 'future'): Headline | null {
  const errors = scores?.[0]?.[part];
  for (const measure of ['track_m', 'coordinate_m', 'chamfer_l2_m'] as const) {
    const error_m = errors?.[measure];
    const word = MEASURES.find(([own]) => own === measure)?.[1] ?? '';
    if (isNumber(error_m)) return { measure, word, error_m };
  }
  return null;
}

/** The error of a twin with its measure, as a cell of a list. */
export function twinErrorCell({ quality }: Pick<Twin, 'quality'>): Child {
  const headline = headlineOf(quality as Quality);
  return errorCell(headline?.error_m, headline?.word);
}

/** The choice of the fit among its starts, in a sentence; null for a single start. */
export function choiceText({ choice }: Quality): string | null {
  if (choice === undefined || choice.losses.length < 2) return null;
  const by =
    choice.held_back_frames > 0
      ? `best predicts the ${choice.held_back_frames} held-back frames`
      : 'has the lowest loss over the training frames';
  return `Start ${choice.start + 1} of ${choice.losses.length} was chosen: it ${by}.`;
}

/** The spread of several fits in sentences; null for a single fit. */
export function spreadText({ spread }: Quality): string | null {
  if (spread === undefined) return null;
  const { fits, mean_m, error_m, within, rank_correlation } = spread;
  const off = millimetres(error_m);
  const apart = `The predictions of ${fits} fits are ${millimetres(mean_m)} apart where the twin is off by ${off}.`;
  const share = `${Math.round(within * 100)} % of the points have at most twice the expected error`;
  if (rank_correlation === null || rank_correlation === undefined) return `${apart} ${share}.`;
  return `${apart} ${share}, and spread and error agree in rank by ${rank_correlation.toFixed(2)}.`;
}

/** Share by which errors of two fits differ although only their seeds do. */
const SEEDS_DIFFER = 0.15;

/** Two errors in a sentence: by how much the second is larger or smaller, if not by chance alone. */
export function comparedText(first: string, second: string, a: number | null, b: number | null): string | null {
  if (a === null || b === null) return null;
  const both = (one: number, other: number): string => `${millimetres(one)} against ${millimetres(other)}`;
  if (Math.max(a, b) <= (1 + SEEDS_DIFFER) * Math.min(a, b)) {
    return `No difference between ${first} and ${second} beyond that of seeds: ${both(a, b)}.`;
  }
  const [better, worse, ratio] = a < b ? [first, second, b / a] : [second, first, a / b];
  const factor = ratio.toFixed(2);
  const errors = both(Math.min(a, b), Math.max(a, b));
  return `${better} is better than ${worse} by a factor of ${factor} on frames that were not fitted: ${errors}.`;
}

/** The best of several errors in a sentence, with those that differ from it by chance alone; null if one is missing. */
export function bestText(names: readonly string[], errors: readonly (number | null)[]): string | null {
  const known = errors.filter(isNumber);
  if (known.length < errors.length || known.length === 0) return null;
  const least = Math.min(...known);
  const best = names[known.indexOf(least)] ?? '';
  const alike = names.filter((name, index) => name !== best && known[index]! <= (1 + SEEDS_DIFFER) * least);
  const text = `${best} has the lowest error on frames that were not fitted, ${millimetres(least)}`;
  if (alike.length === 0) return `${text}.`;
  return `${text}; that of ${new Intl.ListFormat('en-GB').format(alike)} is no different beyond seeds.`;
}

function isNumber(value: number | null | undefined): value is number {
  return typeof value === 'number';
}
