import { millimetres } from '../../../ui/format';
import { headlineOf, type Measure, type Quality } from '../quality';
import type { Scale } from './scale';

export type Level = 'good' | 'fair' | 'poor';

/** What the error is compared with. */
export type Compared = 'error' | 'still' | 'size' | 'spacing' | 'bias' | 'train' | 'axial';

/** A number that the verdict compares the twin's error with. */
export interface Reason {
  readonly of: Compared;
  readonly name: string;
  readonly value_m: number;
  /** The measure of an error in a word; `length` of a length. */
  readonly measure: string;
  /** The error as a share of this number; null for the error itself. */
  readonly share: number | null;
  /** What the comparison alone would call the twin; null if it does not decide. */
  readonly level: Level | null;
  readonly meaning: string;
}

/** Bounds of a good twin and of a fair one: docs/use/accuracy.md, Verdict of a twin. */
const OF_SIZE = [0.03, 0.06] as const;
const OF_STANDING_STILL = [0.2, 0.33] as const;

/** Those that are lengths; others are errors. */
const LENGTHS: readonly Compared[] = ['size', 'spacing'];
/** Numbers below this have no ratio [m]. */
const LEAST_M = 1e-6;

/** What an error is a mean of, by measure. */
const MEANINGS: Partial<Record<Measure, string>> = {
  track_m: 'Mean distance between a tracked point and its place on the twin',
  coordinate_m: 'Mean difference of a coordinate of a marker',
  chamfer_l2_m: 'Mean distance of an observed point from the surface of the twin (Chamfer distance)',
};

/** The numbers behind a verdict, the error itself first; empty if no frame was left to measure it on. */
export function reasonsOf(quality: Quality, scale: Scale | null): Reason[] {
  const headline = headlineOf(quality);
  if (headline === null) return [];
  const { measure, error_m, word } = headline;
  const own = quality.scores?.[0];
  const beside = (predictor: string): number | null => {
    const score = quality.scores?.slice(1).find((other) => other.predictor === predictor);
    const value = score?.future[measure];
    return typeof value === 'number' && value > 0 ? value : null;
  };
  const [still, constant, axial] = [beside('standing_still'), beside('last_residual'), beside('axial')];
  const train = own?.train[measure];
  const size = scale !== null && scale.size_m > 0 ? scale.size_m : null;
  const spacing = scale !== null && scale.spacing_m > 0 ? scale.spacing_m : null;
  const reason = (
    of: Compared,
    name: string,
    value_m: number | null | undefined,
    rest: (value: number) => Pick<Reason, 'level' | 'meaning'>,
  ): Reason[] => {
    if (typeof value_m !== 'number') return [];
    const share = of === 'error' ? null : error_m / Math.max(value_m, LEAST_M);
    return [{ of, name, value_m, measure: LENGTHS.includes(of) ? 'length' : word, share, ...rest(value_m) }];
  };
  return [
    ...reason('error', 'Error on later frames', error_m, () => ({
      level: null,
      meaning: `${MEANINGS[measure] ?? 'Mean error'}, over frames that it was not fitted to.`,
    })),
    ...reason('still', 'Standing still', still, (value) => ({
      level: levelOf(error_m / value, OF_STANDING_STILL),
      meaning: 'Error if the object did not move. Good up to 20 % of it, fair up to 33 %.',
    })),
    ...reason('size', 'Size of the object', size, (value) => ({
      level: levelOf(error_m / value, OF_SIZE),
      meaning: 'Diagonal of the box around the object at rest. Good up to 3 % of it, fair up to 6 %.',
    })),
    ...reason('spacing', 'Spacing of the nodes', spacing, (value) => ({
      level: error_m <= value ? 'good' : 'fair',
      meaning: 'Distance between neighbouring nodes. Good up to 100 %: a larger error is one of motion, which more nodes do not lower.',
    })),
    ...reason('bias', 'Constant-bias correction', constant, (value) => ({
      level: error_m <= value ? 'good' : 'fair',
      meaning:
        'The twin with its error in the last fitted frame added to all later ones. Good up to 100 %: if the correction is nearer, ' +
        'the error lasts.',
    })),
    ...reason('train', 'Error on fitted frames', train, (value) => ({
      level: levelOf(size === null ? 0 : value / size, OF_SIZE),
      meaning:
        `How well it follows the frames that it was fitted to.${size === null ? '' : ` It is ${shareText(value / size)} of the size:`}` +
        ' good up to 3 % of the size, fair up to 6 %.',
    })),
    ...reason('axial', 'Springs without bending', axial, () => ({
      level: null,
      meaning: 'The same fit without resistance to bending. This comparison does not decide.',
    })),
  ];
}

/** The comparisons that a verdict of this level is due to; of a good one, none. */
export function decisive(reasons: readonly Reason[], level: string): Reason[] {
  return level === 'good' ? [] : reasons.filter((reason) => reason.level === level);
}

/** A twin's error and the measure that it was found by, as "6.1 mm (tracks)"; a dash if it has none. */
export function errorText(quality: Quality): string {
  const headline = headlineOf(quality);
  return headline === null ? '–' : `${millimetres(headline.error_m)} (${headline.word})`;
}

/** A share with three digits, as 6.6 % or 146 %. */
export function shareText(share: number): string {
  const value = 100 * share;
  return `${value >= 100 ? value.toFixed(0) : Number(value.toPrecision(value < 10 ? 2 : 3))} %`;
}

function levelOf(ratio: number, [good, fair]: readonly [number, number]): Level {
  if (ratio <= good) return 'good';
  return ratio <= fair ? 'fair' : 'poor';
}
