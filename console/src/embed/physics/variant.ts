import { inverseMasses, type Model, type Springs, type Triplets } from './model';

/** A copy of a twin with fewer substeps, which its fit has measured: docs/formats/twin.md, `quality.fast`. */
export interface FastVariant {
  readonly substeps: number;
  /** Rate to which springs and triplets are softened; absent if they are as fitted. */
  readonly rate_limit?: number;
}

/** The twin without what holds it: no control points, no pins, and so no torque in rods. */
export function withoutHands(model: Model): Model {
  const { springs, triplets, rest } = model;
  const isFree = (...ends: (number | undefined)[]): boolean => ends.every((end) => 3 * end! < rest.length);
  const ofSprings = Array.from(springs.rest.keys()).filter((s) => isFree(...springs.ends.subarray(2 * s, 2 * s + 2)));
  const ofTriplets = Array.from(triplets.restBend.keys()).filter((t) => isFree(...triplets.ends.subarray(3 * t, 3 * t + 3)));
  return {
    ...model,
    controls: new Float64Array(0),
    hands: new Uint32Array(0),
    pins: { nodes: new Uint32Array(0), controls: new Uint32Array(0), offsets: new Float64Array(0) },
    rods: [],
    springs: {
      ends: Uint32Array.from(ofSprings.flatMap((s) => [...springs.ends.subarray(2 * s, 2 * s + 2)])),
      rate: Float64Array.from(ofSprings, (s) => springs.rate[s]!),
      rest: Float64Array.from(ofSprings, (s) => springs.rest[s]!),
      dashpot: Float64Array.from(ofSprings, (s) => springs.dashpot[s]!),
    },
    triplets: {
      ends: Uint32Array.from(ofTriplets.flatMap((t) => [...triplets.ends.subarray(3 * t, 3 * t + 3)])),
      stiffness: Float64Array.from(ofTriplets, (t) => triplets.stiffness[t]!),
      damping: Float64Array.from(ofTriplets, (t) => triplets.damping[t]!),
      restBend: Float64Array.from(ofTriplets, (t) => triplets.restBend[t]!),
    },
  };
}

/** The fast variant of a twin. */
export function fastVariant(model: Model, { substeps, rate_limit: limit }: FastVariant): Model {
  if (limit === undefined) return { ...model, substeps };
  const dt = 1 / (model.fps * substeps);
  const inverse = Float64Array.from([...inverseMasses(model), ...model.controls.map(() => 0)]);
  const x = Float64Array.from([...model.rest, ...model.controls]);
  return {
    ...model,
    substeps,
    springs: softSprings(model.springs, inverse, limit, dt),
    triplets: softTriplets(model.triplets, inverse, x, limit, dt),
  };
}

function softSprings(springs: Springs, inverse: Float64Array, limit: number, dt: number): Springs {
  const { ends, rate, dashpot } = springs;
  const weight = (s: number): number => inverse[ends[2 * s]!]! + inverse[ends[2 * s + 1]!]!;
  return {
    ...springs,
    rate: rate.map((value, s) => Math.min(value, limit / (dt * dt * weight(s)))),
    dashpot: dashpot.map((value, s) => Math.min(value, limit / (2 * dt * weight(s)))),
  };
}

function softTriplets(triplets: Triplets, inverse: Float64Array, x: Float64Array, limit: number, dt: number): Triplets {
  const { ends, stiffness, damping } = triplets;
  const weight = (t: number): number => {
    const [i, j, k] = [ends[3 * t]!, ends[3 * t + 1]!, ends[3 * t + 2]!];
    const [u, w] = [1 / distance(x, i, j), 1 / distance(x, k, j)];
    return inverse[i]! * u * u + inverse[k]! * w * w + inverse[j]! * (u + w) ** 2;
  };
  return {
    ...triplets,
    stiffness: stiffness.map((value, t) => Math.min(value, limit / (dt * dt * weight(t)))),
    damping: damping.map((value, t) => Math.min(value, limit / (2 * dt * weight(t)))),
  };
}

function distance(x: Float64Array, a: number, b: number): number {
  return Math.hypot(x[3 * a]! - x[3 * b]!, x[3 * a + 1]! - x[3 * b + 1]!, x[3 * a + 2]! - x[3 * b + 2]!);
}
