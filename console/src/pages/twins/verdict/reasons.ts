import { millimetres } from '../../../ui/format';
import { headlineOf, type Measure, type Quality } from '../quality';
import type { Scale } from './scale';

export type Level = 'good' | 'fair' | 'poor';

/** A number that the verdict compares the twin's error with. */
export interface Reason {
  readonly name: string;
  readonly value_m: number;
  /** The error relative to this number, in words; empty for the error itself. */
  readonly relation: string;
  /** What the comparison alone would call the twin; null if it does not decide. */
  readonly level: Level | null;
  readonly meaning: string;
}

/** Bounds of a good twin and of a fair one: docs/use/accuracy.md, Verdict of a twin. */
const OF_SIZE = [0.03, 0.06] as const;
const OF_STANDING_STILL = [0.2, 0.33] as const;

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
  const reason = (name: string, value_m: number | null | undefined, of: (value: number) => Omit<Reason, 'name' | 'value_m'>): Reason[] =>
    typeof value_m === 'number' ? [{ name, value_m, ...of(value_m) }] : [];
  return [
    ...reason(`Error on later frames (${word})`, error_m, () => ({
      relation: '',
      level: null,
      meaning: `${MEANINGS[measure] ?? 'Mean error'}, over frames that it was not fitted to.`,
    })),
    ...reason('Standing still', still, (value) => ({
      relation: timesText(error_m, value),
      level: levelOf(error_m / value, OF_STANDING_STILL),
      meaning: 'Error if the object did not move. Good up to 20 % of it, fair up to 33 %.',
    })),
    ...reason('Size of the object', size, (value) => ({
      relation: `${shareText(error_m / value)} of it`,
      level: levelOf(error_m / value, OF_SIZE),
      meaning: 'Diagonal of the box around the object at rest. Good up to 3 % of it, fair up to 6 %.',
    })),
    ...reason('Spacing of the nodes', spacing, (value) => ({
      relation: timesText(error_m, value),
      level: error_m <= value ? 'good' : 'fair',
      meaning: 'Distance between neighbouring nodes. A larger error is one of motion, which more nodes do not lower.',
    })),
    ...reason('Constant-bias correction', constant, (value) => ({
      relation: timesText(error_m, value),
      level: error_m <= value ? 'good' : 'fair',
      meaning: 'The twin with its error in the last fitted frame added to all later ones. If that is nearer, its error lasts.',
    })),
    ...reason('Error on fitted frames', train, (value) => ({
      relation: timesText(error_m, value),
      level: levelOf(size === null ? 0 : value / size, OF_SIZE),
      meaning: 'How well it follows the frames that it was fitted to. Good up to 3 % of the size, fair up to 6 %.',
    })),
    ...reason('Springs without bending', axial, (value) => ({
      relation: timesText(error_m, value),
      level: null,
      meaning: 'The same fit without resistance to bending. This comparison does not decide.',
    })),
  ];
}

/** Names of the comparisons that a verdict of this level is due to; of a good one, none. */
export function decisive(reasons: readonly Reason[], level: string): string[] {
  return level === 'good' ? [] : reasons.filter((reason) => reason.level === level).map(({ name }) => name);
}

/** The error relative to another length, as "6.8 times less". */
export function timesText(error_m: number, other_m: number): string {
  const [ratio, word] = error_m <= other_m ? [other_m / Math.max(error_m, 1e-6), 'less'] : [error_m / other_m, 'more'];
  return ratio < 1.005 ? 'the same' : `${ratio < 10 ? Number(ratio.toPrecision(3)) : Math.round(ratio)} times ${word}`;
}

/** The first sentence of a verdict up to its colon: what the twin is worth in one number. */
export function firstSentence(why: string): string {
  const end = /[:.](?=\s|$)/.exec(why);
  return end === null ? why : `${why.slice(0, end.index)}.`;
}

/** A twin's error and the measure that it was found by, as "6.1 mm (tracks)"; a dash if it has none. */
export function errorText(quality: Quality): string {
  const headline = headlineOf(quality);
  return headline === null ? '–' : `${millimetres(headline.error_m)} (${headline.word})`;
}

function shareText(share: number): string {
  return `${(100 * share).toFixed(1)} %`;
}

function levelOf(ratio: number, [good, fair]: readonly [number, number]): Level {
  if (ratio <= good) return 'good';
  return ratio <= fair ? 'fair' : 'poor';
}
