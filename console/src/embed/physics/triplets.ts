import type { Triplets } from './model';

/** Square of the length of an arm below which it has no direction [m²]. */
const LEAST_ARM = 1e-12;
/** Square of the sine below which a triplet has no plane. */
const LEAST_SINE = 1e-8;
/** Width of the rounding, as a share of the bend at rest. */
const ROUNDING = 0.5;
/** q at rest as a multiple of the bend at rest. */
const ROUNDED_REST = Math.sqrt(1 + ROUNDING * ROUNDING);
/** tan(pi/8) */
const TAN_EIGHTH = Math.SQRT2 - 1;

/**
 * Adds -[k (q - q0) + c dq/dt] ∂q/∂x of every triplet to the forces of its endpoints, with q the rounded bend of
 * docs/formats/twin.md, Triplets; positions, velocities and forces have the shape [N + C, 3].
 */
export function addTripletForces(triplets: Triplets, x: Float64Array, v: Float64Array, forces: Float64Array): void {
  const { ends, stiffness, damping, restBend } = triplets;
  for (let t = 0; t < restBend.length; t += 1) {
    const i = 3 * ends[3 * t]!;
    const j = 3 * ends[3 * t + 1]!;
    const k = 3 * ends[3 * t + 2]!;
    const ux = x[i]! - x[j]!;
    const uy = x[i + 1]! - x[j + 1]!;
    const uz = x[i + 2]! - x[j + 2]!;
    const wx = x[k]! - x[j]!;
    const wy = x[k + 1]! - x[j + 1]!;
    const wz = x[k + 2]! - x[j + 2]!;
    const uu = ux * ux + uy * uy + uz * uz;
    const ww = wx * wx + wy * wy + wz * wz;
    if (!(uu > LEAST_ARM && ww > LEAST_ARM)) continue;
    const nx = uy * wz - uz * wy;
    const ny = uz * wx - ux * wz;
    const nz = ux * wy - uy * wx;
    const nn = nx * nx + ny * ny + nz * nz;
    const cosine = ux * wx + uy * wy + uz * wz;
    // u x n / |u|² and n x w / |w|²: the gradient of the angle times |n|.
    const inverse = 1 / (uu * ww);
    const byU = inverse * ww;
    const byW = inverse * uu;
    const ax = byU * (uy * nz - uz * ny);
    const ay = byU * (uz * nx - ux * nz);
    const az = byU * (ux * ny - uy * nx);
    const bx = byW * (ny * wz - nz * wy);
    const by = byW * (nz * wx - nx * wz);
    const bz = byW * (nx * wy - ny * wx);
    let force: number;
    if (nn >= LEAST_SINE * uu * ww) {
      const sine = Math.sqrt(nn);
      const bend = angle(sine, -cosine);
      const atRest = restBend[t]!;
      const rounded = Math.sqrt(bend * bend + ROUNDING * ROUNDING * atRest * atRest);
      const share = bend / (rounded * sine);
      const rate =
        ax * (v[i]! - v[j]!) + ay * (v[i + 1]! - v[j + 1]!) + az * (v[i + 2]! - v[j + 2]!) +
        bx * (v[k]! - v[j]!) + by * (v[k + 1]! - v[j + 1]!) + bz * (v[k + 2]! - v[j + 2]!);
      force = -share * (stiffness[t]! * (ROUNDED_REST * Math.abs(atRest) - rounded) + damping[t]! * share * rate);
    } else if (restBend[t] === 0 && cosine < 0) {
      force = -stiffness[t]! / cosine;
    } else continue;
    forces[i]! += force * ax;
    forces[i + 1]! += force * ay;
    forces[i + 2]! += force * az;
    forces[k]! += force * bx;
    forces[k + 1]! += force * by;
    forces[k + 2]! += force * bz;
    forces[j]! -= force * (ax + bx);
    forces[j + 1]! -= force * (ay + by);
    forces[j + 2]! -= force * (az + bz);
  }
}

/**
 * atan2 for y of at least 0, as the engine computes it, within 3e-7: `Math.atan2` alone would take half of the time of
 * a triplet. The ratio is brought into [0, tan(pi/8)], and a polynomial (Cephes' `atanf`) does the rest.
 */
function angle(y: number, x: number): number {
  const magnitude = Math.abs(x);
  const low = y < magnitude ? y : magnitude;
  const high = y < magnitude ? magnitude : y;
  const isUpper = low > TAN_EIGHTH * high;
  const t = isUpper ? (low - high) / (low + high) : low / high;
  const z = t * t;
  const series = ((8.0537445e-2 * z - 1.3877686e-1) * z + 1.9977711e-1) * z - 3.333295e-1;
  let turn = series * z * t + t + (isUpper ? Math.PI / 4 : 0);
  if (y > magnitude) turn = Math.PI / 2 - turn;
  return x < 0 ? Math.PI - turn : turn;
}
