import type { LossCurve } from '../../api/types';

/** A line of a chart. */
export interface Line {
  readonly label: string;
  /** True of the lowest loss so far, false of the loss itself. */
  readonly isBest: boolean;
  /** Which of the models it is of, for its colour. */
  readonly model: number;
  /** Losses by iteration of the chart; null for those without a logarithm. */
  readonly values: readonly (number | null)[];
}

/** Data of the chart of one stage. */
export interface StageChart {
  readonly stage: string;
  /** Ascending. */
  readonly iterations: readonly number[];
  readonly lines: readonly Line[];
}

/** Curves as charts, one for each stage, in the order of the stages. */
export function chartsOf(curves: readonly LossCurve[]): StageChart[] {
  const stages = [...new Set(curves.map(({ stage }) => stage))];
  const models = [...new Set(curves.map(({ variant }) => variant))];
  return stages.map((stage) => {
    const own = curves.filter((curve) => curve.stage === stage);
    const iterations = [...new Set(own.flatMap((curve) => curve.iterations))].sort((a, b) => a - b);
    const lines = own.flatMap((curve) => {
      const line = (isBest: boolean): Line => ({
        label: isBest ? `${curve.variant}, best` : curve.variant,
        isBest,
        model: models.indexOf(curve.variant),
        values: spread(iterations, curve, isBest ? curve.best_losses : curve.losses),
      });
      return [line(false), line(true)];
    });
    return { stage, iterations, lines };
  });
}

function spread(
  iterations: readonly number[],
  curve: LossCurve,
  values: readonly (number | null)[],
): (number | null)[] {
  const known = new Map(curve.iterations.map((iteration, index) => [iteration, values[index] ?? null]));
  return iterations.map((iteration) => {
    const value = known.get(iteration) ?? null;
    return value !== null && value > 0 ? value : null;
  });
}

/** Progress of a model: its last iteration, its last loss and its lowest. */
export interface LastLoss {
  readonly stage: string;
  readonly variant: string;
  readonly iteration: number;
  readonly loss: number | null;
  readonly best: number | null;
}

/** The ends of all curves. */
export function lastLosses(curves: readonly LossCurve[]): LastLoss[] {
  return curves.map(({ stage, variant, iterations, losses, best_losses }) => ({
    stage,
    variant,
    iteration: iterations.at(-1) ?? 0,
    loss: losses.at(-1) ?? null,
    best: best_losses.at(-1) ?? null,
  }));
}

/** A loss with three digits, as 3.25e-5. */
export function lossText(loss: number | null): string {
  if (loss === null) return 'not finite';
  return loss !== 0 && (loss < 0.001 || loss >= 10_000) ? loss.toExponential(2) : String(Number(loss.toPrecision(3)));
}
