/** Lengths that errors of a twin are compared with, as the server computes them (crates/eval/src/assess.rs). */
export interface Scale {
  /** Mean distance of a node to its sixth neighbour [m]; of a cable, of two nodes that follow one another on a rod. */
  readonly spacing_m: number;
  /** Size of the object: diagonal of the box around the nodes at rest [m]. */
  readonly size_m: number;
}

/** Which neighbour of a node is as far as the spacing. */
const NEIGHBOUR = 6;

/** Lengths of nodes at rest [m], shape [N, 3], and of the nodes of each rod. */
export function scaleOf(rest: Float32Array, rods: readonly Uint32Array[]): Scale {
  return { spacing_m: rodSpacing(rest, rods) ?? nodeSpacing(rest), size_m: diagonal(rest) };
}

function diagonal(rest: Float32Array): number {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  rest.forEach((x, i) => {
    low[i % 3] = Math.min(low[i % 3]!, x);
    high[i % 3] = Math.max(high[i % 3]!, x);
  });
  return rest.length === 0 ? 0 : Math.hypot(...high.map((x, axis) => x - low[axis]!));
}

function rodSpacing(rest: Float32Array, rods: readonly Uint32Array[]): number | null {
  const lengths = rods.flatMap((rod) => Array.from(rod.subarray(1), (node, i) => distance(rest, rod[i]!, node)));
  return lengths.length === 0 ? null : mean(lengths);
}

function nodeSpacing(rest: Float32Array): number {
  const count = rest.length / 3;
  if (count < 2) return 0;
  const neighbour = Math.min(NEIGHBOUR, count - 1);
  return mean(
    Array.from({ length: count }, (_, node) => {
      // The node itself is the first.
      const all = Float32Array.from({ length: count }, (_, other) => distance(rest, node, other));
      return all.sort()[neighbour]!;
    }),
  );
}

function distance(rest: Float32Array, i: number, j: number): number {
  return Math.hypot(rest[3 * i]! - rest[3 * j]!, rest[3 * i + 1]! - rest[3 * j + 1]!, rest[3 * i + 2]! - rest[3 * j + 2]!);
}

function mean(values: readonly number[]): number {
  return values.reduce((sum, value) => sum + value, 0) / values.length;
}
