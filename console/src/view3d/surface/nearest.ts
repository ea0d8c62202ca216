/** Points on a grid, among which the nearest to others are found. */
export class Nearest {
  readonly #cells = new Map<number, number[]>();
  readonly #low: [number, number, number] = [Infinity, Infinity, Infinity];
  readonly #counts: [number, number, number] = [1, 1, 1];
  readonly #size: number;

  /** `points` [m], shape [M, 3]; `reach` is about the distance between neighbours [m]. */
  constructor(
    private readonly points: Float32Array,
    reach: number,
  ) {
    const high = [-Infinity, -Infinity, -Infinity];
    points.forEach((x, i) => {
      this.#low[i % 3 as 0 | 1 | 2] = Math.min(this.#low[i % 3 as 0 | 1 | 2], x);
      high[i % 3] = Math.max(high[i % 3]!, x);
    });
    const extent = Math.max(...high.map((x, axis) => x - this.#low[axis]!), 0);
    // Few enough cells that an object that has come apart does not fill the memory.
    this.#size = Math.max(reach, extent / 40, 1e-9);
    high.forEach((x, axis) => (this.#counts[axis] = Math.floor((x - this.#low[axis]!) / this.#size) + 1));
    for (let i = 0; 3 * i < points.length; i += 1) {
      const key = this.#key(...this.#cell(points, i));
      const cell = this.#cells.get(key);
      if (cell === undefined) this.#cells.set(key, [i]);
      else cell.push(i);
    }
  }

  /** Distance from point i of `others` to the nearest one [m]; not a number if either is missing. */
  distance(others: Float32Array, i: number): number {
    return Math.sqrt(this.#search(others, i)?.square ?? NaN);
  }

  /** Number of the point nearest to point i of `others`; null if either is missing. */
  index(others: Float32Array, i: number): number | null {
    return this.#search(others, i)?.point ?? null;
  }

  /** The nearest point, and the square of its distance. */
  #search(others: Float32Array, i: number): { readonly point: number; readonly square: number } | null {
    const [x, y, z] = [others[3 * i]!, others[3 * i + 1]!, others[3 * i + 2]!];
    if (Number.isNaN(x) || this.points.length === 0) return null;
    let nearest = 0;
    const cell = this.#cell(others, i);
    let best = Infinity;
    const farthest = Math.max(...cell.map((c, axis) => Math.max(Math.abs(c), Math.abs(this.#counts[axis]! - 1 - c))));
    for (let ring = this.#outside(cell); ring <= farthest; ring += 1) {
      // Everything in this ring of cells and beyond it is farther than that.
      if (Math.sqrt(best) <= (ring - 1) * this.#size) break;
      this.#visit(cell, ring, (point) => {
        const at = (axis: number): number => this.points[3 * point + axis]!;
        const [dx, dy, dz] = [at(0) - x, at(1) - y, at(2) - z];
        const square = dx * dx + dy * dy + dz * dz;
        if (square < best) [best, nearest] = [square, point];
      });
    }
    return { point: nearest, square: best };
  }

  /** The first ring around a cell that has any cell of the grid. */
  #outside(cell: readonly number[]): number {
    return Math.max(...cell.map((c, axis) => Math.max(-c, c - (this.#counts[axis]! - 1), 0)));
  }

  #visit(center: readonly [number, number, number], ring: number, seen: (point: number) => void): void {
    const span = (axis: 0 | 1 | 2): [number, number] =>
      [Math.max(center[axis] - ring, 0), Math.min(center[axis] + ring, this.#counts[axis] - 1)];
    const [[x0, x1], [y0, y1], [z0, z1]] = [span(0), span(1), span(2)];
    for (let x = x0; x <= x1; x += 1) {
      for (let y = y0; y <= y1; y += 1) {
        const isEdge = Math.abs(x - center[0]) === ring || Math.abs(y - center[1]) === ring;
        for (let z = z0; z <= z1; z += 1) {
          if (!isEdge && Math.abs(z - center[2]) !== ring) continue;
          this.#cells.get(this.#key(x, y, z))?.forEach(seen);
        }
      }
    }
  }

  #cell(points: Float32Array, i: number): [number, number, number] {
    const of = (axis: 0 | 1 | 2): number => Math.floor((points[3 * i + axis]! - this.#low[axis]) / this.#size);
    return [of(0), of(1), of(2)];
  }

  #key(x: number, y: number, z: number): number {
    return (x * this.#counts[1] + y) * this.#counts[2] + z;
  }
}
