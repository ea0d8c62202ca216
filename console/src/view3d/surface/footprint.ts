import type { Plane } from '../shape';

/** Cells along each side of the grid, those at its edges without shade. */
export const SIDE = 64;
/** Cells by which blurring widens a shadow. */
const BLUR = 3;
/** Height that halves a shadow [m], and depth below the ground from which nothing casts one. */
const HALF_M = 0.12;
const DEEPEST_M = 0.01;

/** What casts a shadow: triangles, or points without any. */
export interface Caster {
  /** [m], shape [V, 3] */
  readonly positions: Float32Array;
  /** Shape [F, 3]; without faces each point is a disc. */
  readonly faces: Uint32Array;
  /** Radius of the discs [m]. */
  readonly radius: number;
}

/**
 * The soft shadow of an object straight below it on a plane: triangles are filled into a coarse grid, the higher the
 * fainter, and the grid is blurred. The cells keep their places in the plane, so that an object at rest has a shadow
 * at rest.
 */
export class Footprint {
  /** Shade of each cell, shape [SIDE, SIDE], row by row along the second axis. */
  readonly cells = new Uint8Array(SIDE * SIDE);
  /** Side of a cell [m]. */
  cell: number;
  /** First cell of the grid along both axes, counted from the foot of the origin of the world. */
  corner: readonly [number, number] = [0, 0];
  /** Columns and rows of the grid, from the corner, that have any shade. */
  used: readonly [number, number] = [0, 0];
  readonly #axes: readonly [Vector, Vector];
  readonly #normal: Vector;
  readonly #offset: number;
  readonly #least: number;
  readonly #shades = new Float32Array(SIDE * SIDE);
  readonly #rows = new Float32Array(SIDE * SIDE);
  #flat = new Float32Array(0);

  /** `size` is that of the object [m], which the grid is fine enough for. */
  constructor(plane: Plane, size: number) {
    const length = Math.hypot(...plane.normal) || 1;
    const [x, y, z] = plane.normal;
    this.#normal = [x / length, y / length, z / length];
    this.#offset = plane.offset_m;
    this.#axes = axesOf(this.#normal);
    this.cell = this.#least = (1.25 * size) / SIDE;
  }

  /** A point of the plane [m], from its place in cells of the grid, a little above it. */
  point(column: number, row: number): Vector {
    const [e, f] = this.#axes;
    const u = (this.corner[0] + column) * this.cell;
    const v = (this.corner[1] + row) * this.cell;
    const up = this.#offset + 0.001;
    const at = (i: 0 | 1 | 2): number => u * e[i] + v * f[i] + up * this.#normal[i];
    return [at(0), at(1), at(2)];
  }

  /** Casts the shadow anew. */
  cast({ positions, faces, radius }: Caster): void {
    const flat = this.#flatten(positions);
    const [low, high] = boundsOf(flat);
    this.#shades.fill(0);
    this.used = [0, 0];
    if (!(high[0] >= low[0])) return void this.cells.fill(0);
    const room = SIDE - 2 * BLUR - 2;
    const span = Math.max(high[0] - low[0], high[1] - low[1]) + 2 * radius;
    // Doubled, so that the size stays the same while an object is stretched a little more.
    this.cell = this.#least;
    while (span > room * this.cell) this.cell *= 2;
    const first = (axis: 0 | 1): number => Math.floor((low[axis] - radius) / this.cell) - BLUR - 1;
    this.corner = [first(0), first(1)];
    const end = (axis: 0 | 1): number =>
      Math.min(Math.floor((high[axis] + radius) / this.cell) - this.corner[axis] + BLUR + 2, SIDE);
    this.used = [end(0), end(1)];
    for (let i = 0; i < flat.length; i += 3) {
      flat[i] = flat[i]! / this.cell - this.corner[0];
      flat[i + 1] = flat[i + 1]! / this.cell - this.corner[1];
    }
    if (faces.length > 0) for (let f = 0; f < faces.length; f += 3) this.#fill(faces[f]!, faces[f + 1]!, faces[f + 2]!);
    else for (let i = 0; i < flat.length / 3; i += 1) this.#disc(i, radius / this.cell);
    this.#blur();
  }

  /** Places along the axes of the plane, and shade at their height, shape [V, 3]. */
  #flatten(positions: Float32Array): Float32Array {
    if (this.#flat.length !== positions.length) this.#flat = new Float32Array(positions.length);
    const flat = this.#flat;
    const [[ex, ey, ez], [fx, fy, fz]] = this.#axes;
    const [nx, ny, nz] = this.#normal;
    for (let i = 0; i < flat.length; i += 3) {
      const x = positions[i]!;
      const y = positions[i + 1]!;
      const z = positions[i + 2]!;
      const above = nx * x + ny * y + nz * z - this.#offset;
      flat[i] = ex * x + ey * y + ez * z;
      flat[i + 1] = fx * x + fy * y + fz * z;
      flat[i + 2] = above < -DEEPEST_M ? 0 : 255 / (1 + Math.max(above, 0) / HALF_M);
    }
    return flat;
  }

  /** Fills a triangle: the cells whose centres it covers, and the one of its own centre. */
  #fill(a: number, b: number, c: number): void {
    const flat = this.#flat;
    const [ax, ay] = [flat[3 * a]!, flat[3 * a + 1]!];
    const [bx, by] = [flat[3 * b]!, flat[3 * b + 1]!];
    const [cx, cy] = [flat[3 * c]!, flat[3 * c + 1]!];
    const shade = (flat[3 * a + 2]! + flat[3 * b + 2]! + flat[3 * c + 2]!) / 3;
    this.#mark(Math.floor((ax + bx + cx) / 3), Math.floor((ay + by + cy) / 3), shade);
    const [x0, x1] = [Math.ceil(Math.min(ax, bx, cx) - 0.5), Math.floor(Math.max(ax, bx, cx) - 0.5)];
    const [y0, y1] = [Math.ceil(Math.min(ay, by, cy) - 0.5), Math.floor(Math.max(ay, by, cy) - 0.5)];
    for (let row = y0; row <= y1; row += 1) {
      for (let column = x0; column <= x1; column += 1) {
        const [x, y] = [column + 0.5, row + 0.5];
        const p = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
        const q = (cx - bx) * (y - by) - (cy - by) * (x - bx);
        const r = (ax - cx) * (y - cy) - (ay - cy) * (x - cx);
        if ((p >= 0 && q >= 0 && r >= 0) || (p <= 0 && q <= 0 && r <= 0)) this.#mark(column, row, shade);
      }
    }
  }

  #disc(i: number, radius: number): void {
    const [x, y, shade] = [this.#flat[3 * i]!, this.#flat[3 * i + 1]!, this.#flat[3 * i + 2]!];
    this.#mark(Math.floor(x), Math.floor(y), shade);
    for (let row = Math.ceil(y - radius - 0.5); row + 0.5 <= y + radius; row += 1) {
      const half = Math.sqrt(Math.max(radius * radius - (row + 0.5 - y) ** 2, 0));
      for (let column = Math.ceil(x - half - 0.5); column + 0.5 <= x + half; column += 1) this.#mark(column, row, shade);
    }
  }

  #mark(column: number, row: number, shade: number): void {
    if (column < 0 || row < 0 || column >= SIDE || row >= SIDE) return;
    const at = SIDE * row + column;
    if (this.#shades[at]! < shade) this.#shades[at] = shade;
  }

  /** Means over squares, twice, which is nearly a Gaussian. */
  #blur(): void {
    const [columns, rows] = this.used;
    for (const half of [2, BLUR - 2]) {
      blurLines(this.#shades, this.#rows, { lines: rows, step: SIDE, length: columns, stride: 1, half });
      blurLines(this.#rows, this.#shades, { lines: columns, step: 1, length: rows, stride: SIDE, half });
    }
    for (let i = 0; i < this.cells.length; i += 1) this.cells[i] = this.#shades[i]! + 0.5;
  }
}

type Vector = readonly [number, number, number];

/** Two unit vectors that span a plane with a normal; those of the world for the plane z = 0. */
function axesOf([x, y, z]: Vector): readonly [Vector, Vector] {
  const along: Vector = Math.abs(x) < 0.9 ? [1 - x * x, -x * y, -x * z] : [-y * x, 1 - y * y, -y * z];
  const length = Math.hypot(...along);
  const e: Vector = [along[0] / length, along[1] / length, along[2] / length];
  return [e, [y * e[2] - z * e[1], z * e[0] - x * e[2], x * e[1] - y * e[0]]];
}

/** Least and greatest places of what casts a shadow. */
function boundsOf(flat: Float32Array): readonly [readonly [number, number], readonly [number, number]] {
  let [u0, v0, u1, v1] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < flat.length; i += 3) {
    const [u, v] = [flat[i]!, flat[i + 1]!];
    if (!(flat[i + 2]! > 0 && Number.isFinite(u + v))) continue;
    if (u < u0) u0 = u;
    if (u > u1) u1 = u;
    if (v < v0) v0 = v;
    if (v > v1) v1 = v;
  }
  return [[u0, v0], [u1, v1]];
}

interface Lines {
  readonly lines: number;
  readonly step: number;
  readonly length: number;
  readonly stride: number;
  readonly half: number;
}

/** Mean over 2 half + 1 neighbours along each line; beyond its ends there is no shade. */
function blurLines(from: Float32Array, to: Float32Array, { lines, step, length, stride, half }: Lines): void {
  const width = 2 * half + 1;
  for (let line = 0; line < lines; line += 1) {
    const start = line * step;
    let sum = 0;
    for (let i = 0; i < Math.min(half, length); i += 1) sum += from[start + i * stride]!;
    for (let i = 0; i < length; i += 1) {
      if (i + half < length) sum += from[start + (i + half) * stride]!;
      if (i > half) sum -= from[start + (i - half - 1) * stride]!;
      to[start + i * stride] = sum / width;
    }
  }
}
