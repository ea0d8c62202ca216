/** Angular frequency with which what is pulled follows the pointer, as if all of the object were held [1/s]. */
const FREQUENCY = 18;
/** Share of critical damping. */
const DAMPING = 0.8;
/** Largest pull, as a multiple of the object's weight on Earth. */
const MOST_WEIGHTS = 12;
/** Largest product of frequency and substep: beyond it a pull is made softer, so that it stays stable. */
const MOST_PHASE = 0.4;
const EARTH = 9.81;

/** A soft, bounded pull of some nodes towards a place. */
export interface Pull {
  /** Nodes, K of them. */
  readonly nodes: Uint32Array;
  /** Where each node is drawn to, relative to `target` [m], shape [K, 3]. */
  readonly offsets: Float64Array;
  /** Shares of the nodes, which sum to 1. */
  readonly shares: Float64Array;
  /** Stiffness [N/m] and damping [N s/m] of each node. */
  readonly stiffness: Float64Array;
  readonly damping: Float64Array;
  /** Largest force of all nodes together [N]. */
  readonly most: number;
  /** Place that the pointer draws to [m]. */
  readonly target: Float64Array;
}

/** A pull of the nodes within `radius` of a node, least at its edge; positions [N, 3] or more, and masses [N]. */
export function pullAt(node: number, radius: number, x: Float64Array, masses: Float64Array, dt: number): Pull {
  const target = x.slice(3 * node, 3 * node + 3);
  const found: { node: number; weight: number }[] = [];
  masses.forEach((_, n) => {
    const distance = Math.hypot(...target.map((value, c) => x[3 * n + c]! - value));
    const weight = n === node ? 1 : Math.max(0, 1 - distance / radius);
    if (weight > 0) found.push({ node: n, weight });
  });
  const nodes = Uint32Array.from(found, (each) => each.node);
  const total = found.reduce((sum, { weight }) => sum + weight, 0);
  const mass = masses.reduce((sum, each) => sum + each, 0);
  const shares = Float64Array.from(found, ({ weight }) => weight / total);
  const frequencies = shares.map((share, k) =>
    Math.min(FREQUENCY * Math.sqrt((share * mass) / masses[nodes[k]!]!), MOST_PHASE / dt),
  );
  return {
    nodes,
    offsets: Float64Array.from({ length: 3 * nodes.length }, (_, i) => x[3 * nodes[Math.floor(i / 3)]! + (i % 3)]! - target[i % 3]!),
    shares,
    stiffness: frequencies.map((frequency, k) => masses[nodes[k]!]! * frequency ** 2),
    damping: frequencies.map((frequency, k) => 2 * DAMPING * masses[nodes[k]!]! * frequency),
    most: MOST_WEIGHTS * mass * EARTH,
    target,
  };
}

/** Adds the forces of a pull; positions, velocities and forces have the shape [N, 3] or more. */
export function addPull(pull: Pull, x: Float64Array, v: Float64Array, forces: Float64Array): void {
  const { nodes, offsets, target, shares, stiffness, damping, most } = pull;
  for (let k = 0; k < nodes.length; k += 1) {
    const i = 3 * nodes[k]!;
    const fx = stiffness[k]! * (target[0]! + offsets[3 * k]! - x[i]!);
    const fy = stiffness[k]! * (target[1]! + offsets[3 * k + 1]! - x[i + 1]!);
    const fz = stiffness[k]! * (target[2]! + offsets[3 * k + 2]! - x[i + 2]!);
    const bound = Math.min(1, (most * shares[k]!) / Math.max(Math.sqrt(fx * fx + fy * fy + fz * fz), 1e-9));
    forces[i]! += bound * fx - damping[k]! * v[i]!;
    forces[i + 1]! += bound * fy - damping[k]! * v[i + 1]!;
    forces[i + 2]! += bound * fz - damping[k]! * v[i + 2]!;
  }
}
