import type { Law } from './model';

/**
 * Change of a relative velocity by an impact: J n - min(1, mu J / |v_t|) v_t, J = -v_n + e clamp(-s · n, 0, -v_n),
 * with v the velocity just before, and s that at the start of the substep, so that what a force presses does not
 * bounce. Written to `out`.
 */
export function impact(
  { restitution, friction }: Law,
  sx: number, sy: number, sz: number,
  vx: number, vy: number, vz: number,
  nx: number, ny: number, nz: number,
  out: Float64Array,
): void {
  const along = vx * nx + vy * ny + vz * nz;
  const tx = vx - along * nx;
  const ty = vy - along * ny;
  const tz = vz - along * nz;
  const flight = Math.max(0, Math.min(-(sx * nx + sy * ny + sz * nz), -along));
  const impulse = restitution * flight - along;
  const speed = Math.sqrt(tx * tx + ty * ty + tz * tz);
  const brake = friction * impulse < speed ? (friction * impulse) / speed : 1;
  out[0] = impulse * nx - brake * tx;
  out[1] = impulse * ny - brake * ty;
  out[2] = impulse * nz - brake * tz;
}
