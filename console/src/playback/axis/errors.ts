import { predictorText } from '../../pages/twins/quality';
import type { FrameErrors, Prediction } from '../prediction';

/** An error of a prediction in each frame. */
export interface ErrorCurve {
  readonly of: keyof FrameErrors;
  readonly label: string;
  /** What is measured, in a sentence. */
  readonly title: string;
  /** Variable with its colour. */
  readonly series: string;
  /** [m], shape [T]; null where it was not measured. */
  readonly values: readonly (number | null)[];
}

/** The mean error of another prediction, over the frames that were fitted to and over the others [m]. */
export interface Baseline {
  readonly label: string;
  readonly series: string;
  readonly train: number | null;
  readonly future: number | null;
}

/** A frame, and its error [m]. */
export interface Place {
  readonly frame: number;
  readonly error: number;
}

/** The errors that are drawn. */
export const CURVES = [
  {
    of: 'track',
    score: 'track_m',
    label: 'Tracks',
    title: 'Mean distance of predicted points from the same points as they were tracked.',
    series: '--series-1',
  },
  {
    of: 'chamfer',
    score: 'chamfer_l1_m',
    label: 'Surface L1',
    title: 'Mean distance of observed points from the predicted surface, as a sum along the three axes.',
    series: '--series-2',
  },
] as const;
const BASELINE_SERIES = ['--series-6', '--series-3', '--series-4', '--series-5'] as const;

/** The errors of a prediction along time, beside those of others. */
export class Errors {
  readonly curves: readonly ErrorCurve[];
  /** The curve that worst frames and baselines are of: tracks where there are some; null without any error. */
  readonly main: ErrorCurve | null;
  /** Predictions that this one has to beat, by the measure of the main curve. */
  readonly baselines: readonly Baseline[];

  constructor(private readonly prediction: Prediction, frameCount: number) {
    const all = CURVES.map(({ of, label, title, series }) => ({
      of, label, title, series,
      values: Array.from({ length: frameCount }, (_, frame) => prediction.errors(frame)[of]),
    }));
    this.curves = all.filter(({ values }) => values.some((value) => value !== null));
    this.main = this.curves[0] ?? null;
    const score = CURVES.find(({ of }) => of === this.main?.of)?.score ?? 'track_m';
    this.baselines = prediction.scores.slice(1).flatMap(({ predictor, train, future }, i) => {
      const [fitted, later] = [train[score] ?? null, future[score] ?? null];
      if (fitted === null && later === null) return [];
      const series = BASELINE_SERIES[i % BASELINE_SERIES.length]!;
      return [{ label: predictorText(predictor, false), series, train: fitted, future: later }];
    });
  }

  /** The frame with the largest error; null where none was measured. */
  get worst(): Place | null {
    return this.main === null ? null : this.worstOf(this.main);
  }

  /** That by one of the curves. */
  worstOf({ values }: ErrorCurve): Place | null {
    return worstOf(values, 0);
  }

  /** That of the frames which the twin was not fitted to. */
  get worstOfFuture(): Place | null {
    return worstOf(this.main?.values ?? [], this.prediction.trainFrameCount);
  }

  /** Mean errors of a curve over frames that were fitted to and over the others [m]. */
  means({ values }: ErrorCurve): { readonly train: number | null; readonly future: number | null } {
    const { startFrame, trainFrameCount } = this.prediction;
    // The frame in which a prediction begins is not predicted.
    const first = startFrame + 1;
    return {
      train: meanOf(values.slice(first, Math.max(trainFrameCount, first))),
      future: meanOf(values.slice(Math.max(trainFrameCount, first))),
    };
  }
}

function worstOf(values: readonly (number | null)[], from: number): Place | null {
  return values.reduce<Place | null>((worst, error, frame) => {
    return frame < from || error === null || (worst !== null && worst.error >= error) ? worst : { frame, error };
  }, null);
}

function meanOf(values: readonly (number | null)[]): number | null {
  const known = values.filter((value) => value !== null);
  return known.length === 0 ? null : known.reduce((sum, value) => sum + value, 0) / known.length;
}
