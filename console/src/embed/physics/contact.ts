import { impact } from './impact';
import { inverseMasses, type Model } from './model';

/** Distance below which two nodes have no direction [m]. */
const LEAST_DISTANCE = 1e-12;
/** Depth beyond which nodes are pushed apart no faster [m], and the time in which they are [s]. */
const MOST_PUSH = 0.005;
const PUSH_TIME = 0.01;

const change = new Float64Array(3);

/**
 * Contact between nodes by impulses: pairs are found once a frame, and each node takes the mean of the impulses of
 * its pairs in every substep. Unlike in the engine the number of a node's partners has no limit.
 */
export class Contact {
  /** Pairs of nodes that may touch in this frame. */
  #pairs: number[] = [];
  readonly #acts: boolean;
  readonly #joined: ReadonlySet<number>;
  readonly #inverse: Float64Array;
  /** Sum of impulses at each node [shape N, 3], and their number [N]. */
  readonly #sums: Float64Array;
  readonly #counts: Float64Array;

  constructor(private readonly model: Model) {
    const { contact, masses, objects, springs } = model;
    const several = objects.some((object) => object !== objects[0]);
    this.#acts = ((contact.betweenObjects && several) || contact.withinObject) && contact.distance > 0;
    const joined = new Set<number>();
    for (let s = 0; this.#acts && contact.withinObject && s < springs.ends.length; s += 2) {
      joined.add(this.#key(springs.ends[s]!, springs.ends[s + 1]!));
    }
    this.#joined = joined;
    this.#inverse = inverseMasses(model);
    this.#sums = new Float64Array(this.#acts ? 3 * masses.length : 0);
    this.#counts = new Float64Array(this.#acts ? masses.length : 0);
  }

  /** Finds the pairs of a frame from positions and velocities [N, 3] at its start. */
  findPairs(x: Float64Array, v: Float64Array): void {
    this.#pairs = [];
    if (!this.#acts) return;
    const { contact, fps, masses } = this.model;
    const count = masses.length;
    let fastest = 0;
    for (let i = 0; i < 3 * count; i += 3) {
      fastest = Math.max(fastest, v[i]! * v[i]! + v[i + 1]! * v[i + 1]! + v[i + 2]! * v[i + 2]!);
    }
    const travel = (2 * Math.sqrt(fastest)) / fps;
    const reach = contact.distance + Math.min(Math.max(travel, contact.distance), 4 * contact.distance);
    const cells = new Map<string, number[]>();
    const cell = (i: number): [number, number, number] => [
      Math.floor(x[i]! / reach), Math.floor(x[i + 1]! / reach), Math.floor(x[i + 2]! / reach),
    ];
    for (let b = 0; b < count; b += 1) {
      const [cx, cy, cz] = cell(3 * b);
      for (let near = 0; near < 27; near += 1) {
        const key = `${cx - 1 + (near % 3)},${cy - 1 + (Math.floor(near / 3) % 3)},${cz - 1 + Math.floor(near / 9)}`;
        for (const a of cells.get(key) ?? []) if (this.#mayTouch(a, b, x, reach)) this.#pairs.push(a, b);
      }
      const own = `${cx},${cy},${cz}`;
      const others = cells.get(own);
      if (others === undefined) cells.set(own, [b]);
      else others.push(b);
    }
  }

  /**
   * Lets nodes collide: changes the velocities `v` just before contact, `start` are those at the start of the
   * substep; shape [N, 3].
   */
  collide(x: Float64Array, start: Float64Array, v: Float64Array): void {
    const pairs = this.#pairs;
    if (pairs.length === 0) return;
    const [sums, counts, inverse] = [this.#sums, this.#counts, this.#inverse];
    sums.fill(0);
    counts.fill(0);
    for (let p = 0; p < pairs.length; p += 2) {
      const [a, b] = [pairs[p]!, pairs[p + 1]!];
      const both = inverse[a]! + inverse[b]!;
      if (!(both > 0) || !this.#touch(3 * a, 3 * b, x, start, v)) continue;
      counts[a]! += 1;
      counts[b]! += 1;
      for (let c = 0; c < 3; c += 1) {
        sums[3 * a + c]! += change[c]! / both;
        sums[3 * b + c]! -= change[c]! / both;
      }
    }
    for (let n = 0; n < counts.length; n += 1) {
      if (counts[n] === 0) continue;
      for (let c = 0; c < 3; c += 1) v[3 * n + c]! -= (inverse[n]! * sums[3 * n + c]!) / counts[n]!;
    }
  }

  /** Finds the change of a pair's relative velocity; false if the pair is not in contact. */
  #touch(i: number, j: number, x: Float64Array, start: Float64Array, v: Float64Array): boolean {
    const { contact, rest } = this.model;
    let [nx, ny, nz] = [x[j]! - x[i]!, x[j + 1]! - x[i + 1]!, x[j + 2]! - x[i + 2]!];
    const distance = Math.sqrt(nx * nx + ny * ny + nz * nz);
    if (!(distance < contact.distance && distance > LEAST_DISTANCE)) return false;
    [nx, ny, nz] = [nx / distance, ny / distance, nz / distance];
    const [vx, vy, vz] = [v[j]! - v[i]!, v[j + 1]! - v[i + 1]!, v[j + 2]! - v[i + 2]!];
    const hits = vx * nx + vy * ny + vz * nz < 0;
    change.fill(0);
    if (hits) {
      const [sx, sy, sz] = [start[j]! - start[i]!, start[j + 1]! - start[i + 1]!, start[j + 2]! - start[i + 2]!];
      impact(contact, sx, sy, sz, vx, vy, vz, nx, ny, nz, change);
    }
    if (distanceOf(rest, i, j) < contact.distance) return hits;
    const least = Math.min(contact.distance - distance, MOST_PUSH) / PUSH_TIME;
    const lack = least - (nx * (vx + change[0]!) + ny * (vy + change[1]!) + nz * (vz + change[2]!));
    if (!(lack > 0)) return hits;
    change[0]! += lack * nx;
    change[1]! += lack * ny;
    change[2]! += lack * nz;
    return true;
  }

  #mayTouch(a: number, b: number, x: Float64Array, reach: number): boolean {
    if (!(distanceOf(x, 3 * a, 3 * b) <= reach)) return false;
    const { contact, objects } = this.model;
    if (objects[a] !== objects[b]) return contact.betweenObjects;
    return contact.withinObject && !this.#joined.has(this.#key(a, b));
  }

  /** A number for two endpoints in any order. */
  #key(a: number, b: number): number {
    return Math.min(a, b) + Math.max(a, b) * 2 ** 24;
  }
}

function distanceOf(x: Float64Array, i: number, j: number): number {
  return Math.hypot(x[j]! - x[i]!, x[j + 1]! - x[i + 1]!, x[j + 2]! - x[i + 2]!);
}
