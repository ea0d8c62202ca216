/** Lengths that errors of a twin are compared with, as the server computes them (crates/eval/src/assess.rs). */
export interface Scale {
  /** Mean distance of a node to its sixth neighbour [m]; of a cable, of two nodes that follow one another on a rod. */
  readonly spacing_m: number;
  /** Size of the object: diagonal of the box around the nodes at rest [m]. */
  readonly size_m: number;
}

/** Which neighbour of a node is as far as the spacing. */
const NEIGHBOUR = 6;
/** Most nodes whose neighbours are searched; of more, some are taken evenly. */
const MOST = 2000;

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
  const step = Math.ceil(count / MOST);
  return mean(Array.from({ length: Math.ceil(count / step) }, (_, index) => neighbourDistance(rest, index * step, neighbour)));
}

/** Distance of a node to its nth neighbour [m]. */
function neighbourDistance(rest: Float32Array, node: number, nth: number): number {
  const nearest = new Float64Array(nth).fill(Infinity);
  for (let other = 0; other < rest.length / 3; other += 1) {
    const far = other === node ? Infinity : distance(rest, node, other);
    if (far >= nearest[nth - 1]!) continue;
    let place = nth - 1;
    for (; place > 0 && nearest[place - 1]! > far; place -= 1) nearest[place] = nearest[place - 1]!;
    nearest[place] = far;
  }
  return nearest[nth - 1]!;
}

function distance(rest: Float32Array, i: number, j: number): number {
  return Math.hypot(rest[3 * i]! - rest[3 * j]!, rest[3 * i + 1]! - rest[3 * j + 1]!, rest[3 * i + 2]! - rest[3 * j + 2]!);
}

function mean(values: readonly number[]): number {
  return values.reduce((sum, value) => sum + value, 0) / values.length;
}
