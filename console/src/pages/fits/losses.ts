import type { LossCurve } from '@bendtwin/client';

/** A line of a chart. */
export interface Line {
  readonly label: string;
  /** False of a loss beside the lowest so far, and of standing still: they are dotted. */
  readonly isSolid: boolean;
  /** Which of the models it is of, for its colour. */
  readonly model: number;
  /** Values by iteration of the chart; null where nothing is drawn. */
  readonly values: readonly (number | null)[];
}

/** Data of the chart of one stage. */
export interface StageChart {
  readonly stage: string;
  /** Ascending. */
  readonly iterations: readonly number[];
  readonly lines: readonly Line[];
}

/** Losses as charts, one for each stage, in the order of the stages. */
export function chartsOf(curves: readonly LossCurve[]): StageChart[] {
  const stages = [...new Set(curves.map(({ stage }) => stage))];
  const models = [...new Set(curves.map(({ variant }) => variant))];
  return stages.map((stage) => {
    const own = curves.filter((curve) => curve.stage === stage);
    const iterations = [...new Set(own.flatMap((curve) => curve.iterations))].sort((a, b) => a - b);
    const lines = own.flatMap((curve) => {
      const line = (isSolid: boolean): Line => ({
        label: isSolid ? `${curve.variant}, best` : curve.variant,
        isSolid,
        model: models.indexOf(curve.variant),
        // Others have no logarithm.
        values: spread(iterations, curve, isSolid ? curve.best_losses : curve.losses).map((value) =>
          value !== null && value > 0 ? value : null,
        ),
      });
      return [line(false), line(true)];
    });
    return { stage, iterations, lines };
  });
}

/**
 * Errors in millimetres as charts, one for each stage that has some; with the error of standing still [m] in each,
 * if it is known.
 */
export function errorCharts(curves: readonly LossCurve[], baseline_m: number | null): StageChart[] {
  const stages = [...new Set(curves.map(({ stage }) => stage))];
  const models = [...new Set(curves.map(({ variant }) => variant))];
  return stages.flatMap((stage) => {
    const own = curves
      .filter((curve) => curve.stage === stage)
      .map((curve) => ({ curve, errors: curve.errors_m.map((error) => (error === null ? null : 1000 * error)) }))
      .filter(({ errors }) => errors.some((error) => error !== null));
    if (own.length === 0) return [];
    const known = own.flatMap(({ curve, errors }) => curve.iterations.filter((_, i) => errors[i] !== null));
    const iterations = [...new Set(known)].sort((a, b) => a - b);
    const lines = own.map(({ curve, errors }) => ({
      label: curve.variant,
      isSolid: true,
      model: models.indexOf(curve.variant),
      values: spread(iterations, curve, errors),
    }));
    const still = { label: 'standing still', isSolid: false, model: models.length };
    const values = iterations.map(() => 1000 * (baseline_m ?? 0));
    return [{ stage, iterations, lines: baseline_m === null ? lines : [...lines, { ...still, values }] }];
  });
}

function spread(
  iterations: readonly number[],
  curve: LossCurve,
  values: readonly (number | null)[],
): (number | null)[] {
  const known = new Map(curve.iterations.map((iteration, index) => [iteration, values[index] ?? null]));
  return iterations.map((iteration) => known.get(iteration) ?? null);
}

/** Progress of a model: its last iteration, its last loss and its lowest. */
export interface LastLoss {
  readonly stage: string;
  readonly variant: string;
  readonly iteration: number;
  readonly loss: number | null;
  readonly best: number | null;
  /** The last error that was measured [m]. */
  readonly error_m: number | null;
}

/** The ends of all curves. */
export function lastLosses(curves: readonly LossCurve[]): LastLoss[] {
  return curves.map(({ stage, variant, iterations, losses, best_losses, errors_m }) => ({
    stage,
    variant,
    iteration: iterations.at(-1) ?? 0,
    loss: losses.at(-1) ?? null,
    best: best_losses.at(-1) ?? null,
    error_m: errors_m.findLast((error) => error !== null) ?? null,
  }));
}

/** A loss with three digits, as 3.25e-5. */
export function lossText(loss: number | null): string {
  if (loss === null) return 'not finite';
  return loss !== 0 && (loss < 0.001 || loss >= 10_000) ? loss.toExponential(2) : String(Number(loss.toPrecision(3)));
}
