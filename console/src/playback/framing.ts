/** How a camera sees: its vertical angle of view [degrees], and the width of its picture over the height. */
export interface Lens {
  readonly degrees: number;
  readonly aspect: number;
}

type Vector = readonly [number, number, number];

/** Where a camera stands, and the point that it looks at [m]. */
export interface Framing {
  readonly position: Vector;
  readonly target: Vector;
}

/** Way from what is looked at to the camera: from the front and from above, z up. */
const DIRECTION: Vector = [0.35, -1, 0.55];
/** Share of the picture that points fill, along the axis in which they fill more. */
const FILLED = 0.9;

/**
 * The place nearest to points [m], shape [M, 3], from which all are seen. Points that are not numbers are left
 * out; null without any.
 *
 * With coordinates a, b along the picture and c towards the camera, a camera at (x, y, z) sees a point if
 * |a - x| <= t (z - c), t the tangent of half its angle. Both sides bound z from below by lines in x that
 * cross where the camera stands nearest; y is as x.
 */
export function framing(points: Float32Array, { degrees, aspect }: Lens): Framing | null {
  const toward = unit(DIRECTION);
  const right = unit(cross([0, 0, 1], toward));
  const up = cross(toward, right);
  const known: Vector[] = [];
  for (let i = 0; i + 2 < points.length; i += 3) {
    const point: Vector = [points[i]!, points[i + 1]!, points[i + 2]!];
    if (point.every(Number.isFinite)) known.push([dot(point, right), dot(point, up), dot(point, toward)]);
  }
  if (known.length === 0) return null;
  const upright = FILLED * Math.tan((degrees * Math.PI) / 360);
  const bounds = (axis: 0 | 1, t: number): { at: number; least: number } => {
    const high = most(known.map((point) => point[axis] / t + point[2]));
    const low = most(known.map((point) => -point[axis] / t + point[2]));
    return { at: (t * (high - low)) / 2, least: (high + low) / 2 };
  };
  const [x, y] = [bounds(0, upright * aspect), bounds(1, upright)];
  const depths = known.map((point) => point[2]);
  const middle = (most(depths) - most(depths.map((c) => -c))) / 2;
  // Not within a single point.
  const z = Math.max(x.least, y.least, middle + 0.05);
  const along = (depth: number, i: 0 | 1 | 2): number => x.at * right[i] + y.at * up[i] + depth * toward[i];
  const place = (depth: number): Vector => [along(depth, 0), along(depth, 1), along(depth, 2)];
  return { position: place(z), target: place(middle) };
}

function most(values: readonly number[]): number {
  return values.reduce((largest, value) => Math.max(largest, value), -Infinity);
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(a: Vector): Vector {
  const length = Math.hypot(...a);
  return [a[0] / length, a[1] / length, a[2] / length];
}
