import type { Springs } from './model';

/** Square of the length below which a spring has no direction [m²]. */
const LEAST_SQUARE = 1e-24;

/**
 * Adds f_i = [k (l/l0 - 1) + gamma (v_j - v_i) · d] d and f_j = -f_i of every spring to the forces; positions,
 * velocities and forces of endpoints have the shape [N + C, 3].
 */
export function addSpringForces(springs: Springs, x: Float64Array, v: Float64Array, forces: Float64Array): void {
  const { ends, rate, rest, dashpot } = springs;
  for (let s = 0; s < rest.length; s += 1) {
    const i = 3 * ends[2 * s]!;
    const j = 3 * ends[2 * s + 1]!;
    const rx = x[j]! - x[i]!;
    const ry = x[j + 1]! - x[i + 1]!;
    const rz = x[j + 2]! - x[i + 2]!;
    const square = rx * rx + ry * ry + rz * rz;
    if (!(square > LEAST_SQUARE)) continue;
    const closing = rx * (v[j]! - v[i]!) + ry * (v[j + 1]! - v[i + 1]!) + rz * (v[j + 2]! - v[i + 2]!);
    const length = Math.sqrt(square);
    const pull = (rate[s]! * (length - rest[s]!)) / length + (dashpot[s]! * closing) / square;
    forces[i]! += pull * rx;
    forces[i + 1]! += pull * ry;
    forces[i + 2]! += pull * rz;
    forces[j]! -= pull * rx;
    forces[j + 1]! -= pull * ry;
    forces[j + 2]! -= pull * rz;
  }
}
