import { pointCount, placeSkin } from '../../view3d/skin';
import { impact } from './impact';
import type { Ground } from './model';

/** Height below which a node touches the ground [m]. */
const MARGIN = 1e-6;
/** Share of a point's largest weight from which on a node bears the point. */
const BEARING = 0.25;

const change = new Float64Array(3);

/**
 * Moves nodes by a substep: x + v dt, or the way along the ground, which changes `v` too. `start` has the velocities
 * at the start of the substep, `clearance` the heights at which nodes touch the ground; positions and velocities
 * have the shape [N, 3] or more.
 */
export function travel(
  ground: Ground | null,
  clearance: Float64Array,
  dt: number,
  x: Float64Array,
  start: Float64Array,
  v: Float64Array,
): void {
  if (ground === null) {
    for (let i = 0; i < 3 * clearance.length; i += 1) x[i]! += dt * v[i]!;
    return;
  }
  const [nx, ny, nz] = ground.normal;
  for (let n = 0; n < clearance.length; n += 1) {
    const i = 3 * n;
    const along = nx * v[i]! + ny * v[i + 1]! + nz * v[i + 2]!;
    const height = nx * x[i]! + ny * x[i + 1]! + nz * x[i + 2]! - ground.offset - clearance[n]!;
    let left = dt;
    if (along < 0 && height + dt * along < MARGIN) {
      const until = height > MARGIN ? Math.min(-height / along, dt) : 0;
      for (let c = 0; c < 3; c += 1) x[i + c]! += until * v[i + c]!;
      impact(
        ground,
        start[i]!, start[i + 1]!, start[i + 2]!,
        v[i]!, v[i + 1]!, v[i + 2]!,
        nx, ny, nz,
        change,
      );
      for (let c = 0; c < 3; c += 1) v[i + c]! += change[c]!;
      left = dt - until;
    }
    for (let c = 0; c < 3; c += 1) x[i + c]! += left * v[i + c]!;
  }
}

/** Finds the height at which each node touches the ground, from positions [N, 3] at the start of a frame. */
export function findClearance(ground: Ground | null, x: Float64Array, clearance: Float64Array): void {
  clearance.fill(0);
  if (ground === null || ground.skin === null) return;
  const { starts, nodes, weights } = ground.skin;
  const [nx, ny, nz] = ground.normal;
  const points = new Float32Array(3 * pointCount(ground.skin));
  placeSkin(ground.skin, Float32Array.from(x.subarray(0, 3 * clearance.length)), points);
  for (let p = 0; p + 1 < starts.length; p += 1) {
    let largest = 0;
    for (let k = starts[p]!; k < starts[p + 1]!; k += 1) largest = Math.max(largest, weights[k]!);
    const height = nx * points[3 * p]! + ny * points[3 * p + 1]! + nz * points[3 * p + 2]!;
    for (let k = starts[p]!; k < starts[p + 1]!; k += 1) {
      if (!(weights[k]! > 0 && weights[k]! >= BEARING * largest)) continue;
      const i = 3 * nodes[k]!;
      const above = nx * x[i]! + ny * x[i + 1]! + nz * x[i + 2]! - height;
      clearance[nodes[k]!] = Math.max(clearance[nodes[k]!]!, above);
    }
  }
}
