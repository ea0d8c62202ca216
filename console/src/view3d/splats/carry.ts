import { pointCount, placeSkin, type Skin } from '../skin';

/** Steps towards the rotation nearest to a matrix. */
const STEPS = 40;
/** Angle below which a step changes nothing [rad]. */
const LEAST_RAD = 1e-12;

/**
 * Gaussians that nodes carry, as `crates/splat/src/carry.rs` moves them: means as points of a skin, and rotations
 * blended of those of their nodes. `carry.fixture.json` holds both to the same numbers.
 */
export class Carrier {
  readonly #starts: Uint32Array;
  readonly #neighbours: Uint32Array;
  /** Rotations of nodes from rest, x, y, z, w, shape [N, 4]. */
  readonly #turns: Float64Array;

  /** `rest` are nodes [m], shape [N, 3]; `springs` endpoints, of which those from N on are no nodes, shape [E, 2]. */
  constructor(
    private readonly rest: Float32Array,
    springs: Uint32Array,
    private readonly skin: Skin,
  ) {
    const nodes = rest.length / 3;
    const joined = Array.from({ length: nodes }, () => new Set<number>());
    for (let e = 0; e + 1 < springs.length; e += 2) {
      const [a, b] = [springs[e]!, springs[e + 1]!];
      if (a >= nodes || b >= nodes) continue;
      joined[a]!.add(b);
      joined[b]!.add(a);
    }
    this.#starts = new Uint32Array(nodes + 1);
    joined.forEach((of, i) => (this.#starts[i + 1] = this.#starts[i]! + of.size));
    this.#neighbours = Uint32Array.from(joined.flatMap((of) => [...of].sort((a, b) => a - b)));
    this.#turns = new Float64Array(4 * nodes);
  }

  /** Places means [G, 3] and rotations from rest [G, 4] for nodes [N, 3]. */
  at(nodes: Float32Array, means: Float32Array, rotations: Float32Array): void {
    placeSkin(this.skin, nodes, means);
    for (let i = 0; i < this.#starts.length - 1; i += 1) this.#turnNode(nodes, i);
    for (let g = 0; g < pointCount(this.skin); g += 1) this.#blend(g, rotations);
  }

  /** The rotation nearest to the sum over neighbours j of (x_j - x_i) (X_j - X_i)^T. */
  #turnNode(x: Float32Array, i: number): void {
    const a = new Float64Array(9);
    for (let k = this.#starts[i]!, end = this.#starts[i + 1]!; k < end; k += 1) {
      const j = this.#neighbours[k]!;
      for (let row = 0; row < 3; row += 1) {
        const now = x[3 * j + row]! - x[3 * i + row]!;
        for (let column = 0; column < 3; column += 1) {
          a[3 * row + column]! += now * (this.rest[3 * j + column]! - this.rest[3 * i + column]!);
        }
      }
    }
    nearestRotation(a, this.#turns, 4 * i);
  }

  /** Mean of the rotations of a Gaussian's nodes by their weights, with the sign nearer to the first one's. */
  #blend(g: number, out: Float32Array): void {
    const turns = this.#turns;
    const { starts, nodes, weights } = this.skin;
    const first = 4 * nodes[starts[g]!]!;
    let [x, y, z, w] = [0, 0, 0, 0];
    for (let k = starts[g]!, end = starts[g + 1]!; k < end; k += 1) {
      const at = 4 * nodes[k]!;
      const along =
        turns[at]! * turns[first]! + turns[at + 1]! * turns[first + 1]! +
        turns[at + 2]! * turns[first + 2]! + turns[at + 3]! * turns[first + 3]!;
      const weight = along < 0 ? -Math.abs(weights[k]!) : Math.abs(weights[k]!);
      x += weight * turns[at]!;
      y += weight * turns[at + 1]!;
      z += weight * turns[at + 2]!;
      w += weight * turns[at + 3]!;
    }
    const length = Math.hypot(x, y, z, w);
    const has = length > 1e-9;
    out[4 * g] = has ? x / length : turns[first]!;
    out[4 * g + 1] = has ? y / length : turns[first + 1]!;
    out[4 * g + 2] = has ? z / length : turns[first + 2]!;
    out[4 * g + 3] = has ? w / length : turns[first + 3]!;
  }
}

/**
 * The rotation nearest to a matrix [3, 3], found from no rotation by steps of the angle sum r_k x a_k / |sum r_k . a_k|
 * over columns (Müller et al. 2016, "A robust method to extract the rotational part of deformations"), each a right
 * angle at most.
 */
function nearestRotation(a: Float64Array, out: Float64Array, at: number): void {
  let [x, y, z, w] = [0, 0, 0, 1];
  const size = Math.hypot(...a);
  for (let step = 0; step < STEPS && size > 0 && Number.isFinite(size); step += 1) {
    // Columns of the rotation.
    const r = [
      1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
      2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
      2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y),
    ];
    let [tx, ty, tz, along] = [0, 0, 0, 0];
    for (let k = 0; k < 3; k += 1) {
      const [p, q, s] = [r[3 * k]!, r[3 * k + 1]!, r[3 * k + 2]!];
      const [b, c, d] = [a[k]!, a[3 + k]!, a[6 + k]!];
      tx += q * d - s * c;
      ty += s * b - p * d;
      tz += p * c - q * b;
      along += p * b + q * c + s * d;
    }
    const turning = Math.hypot(tx, ty, tz);
    if (turning <= LEAST_RAD * size) break;
    const angle = Math.min(turning / Math.max(Math.abs(along), LEAST_RAD * size), Math.PI / 2);
    const sine = Math.sin(angle / 2) / turning;
    const [dx, dy, dz, dw] = [tx * sine, ty * sine, tz * sine, Math.cos(angle / 2)];
    [x, y, z, w] = [
      dw * x + dx * w + dy * z - dz * y,
      dw * y - dx * z + dy * w + dz * x,
      dw * z + dx * y - dy * x + dz * w,
      dw * w - dx * x - dy * y - dz * z,
    ];
    const length = Math.hypot(x, y, z, w);
    [x, y, z, w] = [x / length, y / length, z / length, w / length];
  }
  out[at] = x;
  out[at + 1] = y;
  out[at + 2] = z;
  out[at + 3] = w;
}
