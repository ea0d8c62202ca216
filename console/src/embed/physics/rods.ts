import type { Rod } from './model';

/** Length of an edge below which it has no direction [m]. */
const LEAST_EDGE = 1e-6;
/** 1 + cosine below which a rod is folded back, and square of the sine below which a branch holds nothing. */
const LEAST_FOLD = 0.01;

/** Rods of a twin, with their twists. */
export class Rods {
  /** Twists [rad], shape [R]. */
  readonly twists: Float64Array;
  /** Derivative of a rod's twist by the positions of its nodes [rad/m], shape [nodes of the longest, 3]. */
  readonly #gradient: Float64Array;

  constructor(private readonly rods: readonly Rod[]) {
    this.twists = new Float64Array(rods.length);
    this.#gradient = new Float64Array(3 * Math.max(0, ...rods.map(({ nodes }) => nodes.length)));
  }

  /**
   * Moves every twist by a substep, and adds -[k (twist - rest) + c d twist/dt] ∂twist/∂x to the forces; the other
   * order would feed energy in. Positions, velocities and forces have the shape [N + C, 3].
   */
  addForces(dt: number, x: Float64Array, v: Float64Array, forces: Float64Array): void {
    const gradient = this.#gradient;
    this.rods.forEach((rod, r) => {
      const { nodes } = rod;
      findGradient(rod, x, gradient);
      let rate = 0;
      for (let n = 0; n < nodes.length; n += 1) {
        const at = 3 * nodes[n]!;
        for (let c = 0; c < 3; c += 1) rate += gradient[3 * n + c]! * v[at + c]!;
      }
      this.twists[r]! += dt * rate;
      const torque = rod.stiffness * (this.twists[r]! - rod.restTwist) + rod.damping * rate;
      for (let n = 0; n < nodes.length; n += 1) {
        const at = 3 * nodes[n]!;
        for (let c = 0; c < 3; c += 1) forces[at + c]! -= torque * gradient[3 * n + c]!;
      }
    });
  }
}

function findGradient({ nodes, hasArm }: Rod, x: Float64Array, out: Float64Array): void {
  out.fill(0);
  for (let n = 1; n < nodes.length - 1; n += 1) {
    const [p, q, r] = [3 * nodes[n - 1]!, 3 * nodes[n]!, 3 * nodes[n + 1]!];
    const [ex, ey, ez] = [x[q]! - x[p]!, x[q + 1]! - x[p + 1]!, x[q + 2]! - x[p + 2]!];
    const [gx, gy, gz] = [x[r]! - x[q]!, x[r + 1]! - x[q + 1]!, x[r + 2]! - x[q + 2]!];
    const e = Math.sqrt(ex * ex + ey * ey + ez * ez);
    const g = Math.sqrt(gx * gx + gy * gy + gz * gz);
    if (!(e > LEAST_EDGE && g > LEAST_EDGE)) continue;
    const overlap = ex * gx + ey * gy + ez * gz;
    const normal = [ey * gz - ez * gy, ez * gx - ex * gz, ex * gy - ey * gx] as const;
    const square = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
    let [a, c] = [0, 0];
    if (hasArm && n === nodes.length - 2) {
      if (!(square > LEAST_FOLD * e * e * g * g)) continue;
      [a, c] = [-overlap / (e * square), -e / square];
    } else {
      const fold = e * g + overlap;
      if (!(fold > LEAST_FOLD * e * g)) continue;
      [a, c] = [1 / (fold * e), -1 / (fold * g)];
    }
    for (let k = 0; k < 3; k += 1) {
      out[3 * n - 3 + k]! += a * normal[k]!;
      out[3 * n + k]! -= (a + c) * normal[k]!;
      out[3 * n + 3 + k]! += c * normal[k]!;
    }
  }
}
