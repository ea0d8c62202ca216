/** Depths that the sort distinguishes. */
const BUCKETS = 1 << 14;

/** Indices of splats from the farthest to the nearest, by a counting sort of their depths. */
export class SplatOrder {
  readonly #depths: Float32Array;
  readonly #counts = new Uint32Array(BUCKETS + 1);

  /** Orders up to `count` splats. */
  constructor(count: number) {
    this.#depths = new Float32Array(count);
  }

  /** Writes the order of those of `chosen` with means [G, 3] along a direction that points away from the eye. */
  sort(
    means: Float32Array,
    chosen: Uint32Array,
    [x, y, z]: readonly [number, number, number],
    out: Uint32Array | Float32Array,
  ): void {
    const depths = this.#depths;
    const counts = this.#counts.fill(0);
    let [low, high] = [Infinity, -Infinity];
    for (let i = 0; i < chosen.length; i += 1) {
      const at = 3 * chosen[i]!;
      const depth = x * means[at]! + y * means[at + 1]! + z * means[at + 2]!;
      depths[i] = depth;
      if (depth < low) low = depth;
      if (depth > high) high = depth;
    }
    const scale = high > low ? (BUCKETS - 1) / (high - low) : 0;
    const bucket = (i: number): number => Math.min(BUCKETS - 1, Math.max(0, Math.floor((high - depths[i]!) * scale))) || 0;
    for (let i = 0; i < chosen.length; i += 1) counts[bucket(i) + 1]! += 1;
    for (let b = 0; b < BUCKETS; b += 1) counts[b + 1]! += counts[b]!;
    for (let i = 0; i < chosen.length; i += 1) out[counts[bucket(i)]!++] = chosen[i]!;
  }
}

/** Indices of splats, those that are seen most first: by opacity and the area that they cover. */
export function byImportance(opacities: Float32Array, scales: Float32Array): Uint32Array {
  const importance = opacities.map((opacity, g) => {
    const [a, b, c] = [scales[3 * g]!, scales[3 * g + 1]!, scales[3 * g + 2]!];
    return opacity * Math.max(a * b, b * c, c * a);
  });
  return Uint32Array.from(opacities.keys()).sort((a, b) => importance[b]! - importance[a]! || a - b);
}
