import type { PlayState } from './protocol/state';

/** Bounds of the time between two states [ms]. */
const LEAST_MS = 8;
const MOST_MS = 120;

/** Places of everything in a picture. */
export interface Shown {
  /** Nodes [m], shape [N, 3]. */
  positions: Float32Array;
  /** Poses of grippers, shape [G, 7], and of colliders, shape [C, 7]. */
  grippers: Float32Array;
  colliders: Float32Array;
}

/**
 * Motion between states. A state is reached in the time that passed between the last two, from what was
 * shown when it came: a picture drawn right after it came has a part of it already.
 */
export class Motion {
  readonly shown: Shown = empty();
  #from: Shown = empty();
  #to: Shown = empty();
  #came = 0;
  #span = 33;

  /** Takes in a state that has come now [ms]. */
  push(state: PlayState, now: number): void {
    const next = shownOf(state);
    const [first, jumps] = [this.#to.positions.length === 0, !sameShape(next, this.#to)];
    if (!first) this.#span = Math.min(Math.max(0.7 * this.#span + 0.3 * (now - this.#came), LEAST_MS), MOST_MS);
    this.#came = now;
    this.#to = next;
    if (jumps) Object.assign(this.shown, copy(next));
    this.#from = copy(this.shown);
  }

  /** Moves what is shown to where it is now; false once it is where the last state is. */
  sample(now: number): boolean {
    // The clock of frames may be a little behind that of events.
    const share = Math.min(Math.max((now - this.#came) / this.#span, 0.05), 1);
    for (const part of ['positions', 'grippers', 'colliders'] as const) {
      const [from, to, shown] = [this.#from[part], this.#to[part], this.shown[part]];
      for (let i = 0; i < to.length; i += 1) shown[i] = from[i]! + share * (to[i]! - from[i]!);
    }
    return share < 1;
  }
}

/** Places control points that grippers carry, from where all of them were when the play began. */
export function carry(
  first: readonly (readonly number[])[],
  hands: readonly number[],
  firstPoses: readonly (readonly number[])[],
  grippers: Float32Array,
  out: Float32Array,
): void {
  first.forEach((control, c) => {
    const hand = hands[c] ?? 0;
    const start = firstPoses[hand] ?? [0, 0, 0];
    const pose = grippers.subarray(7 * hand, 7 * hand + 7);
    const own = [control[0]! - start[0]!, control[1]! - start[1]!, control[2]! - start[2]!] as const;
    out.set(turned(own, pose), 3 * c);
  });
}

/** A vector turned by a pose's quaternion, and moved by its position. */
function turned([x, y, z]: readonly [number, number, number], pose: Float32Array): [number, number, number] {
  const [px, py, pz, a, b, c, d] = pose as unknown as [number, number, number, number, number, number, number];
  const square = a * a + b * b + c * c + d * d || 1;
  // v + 2 (d q x v + q x (q x v)) / |q|^2
  const [ux, uy, uz] = [b * z - c * y, c * x - a * z, a * y - b * x];
  const [wx, wy, wz] = [b * uz - c * uy, c * ux - a * uz, a * uy - b * ux];
  const twice = 2 / square;
  return [px + x + twice * (d * ux + wx), py + y + twice * (d * uy + wy), pz + z + twice * (d * uz + wz)];
}

function shownOf(state: PlayState): Shown {
  const grippers = state.grippers.flatMap(({ position, orientation }) => [...position, ...orientation]);
  return { positions: state.positions, grippers: new Float32Array(grippers), colliders: state.colliders };
}

function sameShape(a: Shown, b: Shown): boolean {
  return a.positions.length === b.positions.length && a.grippers.length === b.grippers.length &&
    a.colliders.length === b.colliders.length;
}

function copy({ positions, grippers, colliders }: Shown): Shown {
  return { positions: positions.slice(), grippers: grippers.slice(), colliders: colliders.slice() };
}

function empty(): Shown {
  return { positions: new Float32Array(0), grippers: new Float32Array(0), colliders: new Float32Array(0) };
}
