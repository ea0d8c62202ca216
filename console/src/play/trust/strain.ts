import type { TwinShape } from '../../view3d/shape';

/** Strain up to which nothing is doubted: recordings of stiff objects have next to none. */
export const LEAST_STRAIN = 0.02;
/** Share of frames in which a spring was at most as strained as its recorded range says. */
const SHARE = 0.995;

/** Largest strains of springs: how far they were stretched, and how far compressed; both are positive. */
export interface Strains {
  readonly stretched: number;
  readonly compressed: number;
}

/** Strain of a twin now, compared with a recorded range. */
export interface Excess {
  /** How many times the range is exceeded by the spring that exceeds it most; at most 1 within it. */
  readonly times: number;
  readonly way: 'stretched' | 'compressed';
  /** How far nodes are beyond it, from 0 for not at all to 1 for twice as far and more, shape [N]. */
  readonly nodes: Float32Array;
}

/** Springs between nodes, of which the strain is compared: those to control points are no material. */
export class Material {
  readonly #ends: Uint32Array;
  readonly #lengths: Float32Array;
  readonly #nodes: Float32Array;
  readonly #count: number;

  constructor({ springs, restLengths, rest }: Pick<TwinShape, 'springs' | 'restLengths' | 'rest'>) {
    this.#count = rest.length / 3;
    const inner = Array.from(restLengths.keys()).filter((s) => {
      return springs[2 * s]! < this.#count && springs[2 * s + 1]! < this.#count && restLengths[s]! > 0;
    });
    this.#ends = Uint32Array.from(inner.flatMap((s) => [springs[2 * s]!, springs[2 * s + 1]!]));
    this.#lengths = Float32Array.from(inner, (s) => restLengths[s]!);
    this.#nodes = new Float32Array(this.#count);
  }

  /**
   * The range of a recorded motion: of each spring what it exceeds in one of 200 frames only, and of these the
   * largest.
   */
  recorded(frames: readonly Float32Array[]): Strains {
    const at = Math.min(Math.floor(SHARE * frames.length), frames.length - 1);
    const range = { stretched: 0, compressed: 0 };
    if (frames.length === 0) return range;
    const strains = new Float32Array(frames.length);
    for (let s = 0; s < this.#lengths.length; s += 1) {
      frames.forEach((nodes, frame) => (strains[frame] = this.#strain(nodes, s)));
      strains.sort();
      range.stretched = Math.max(range.stretched, strains[at]!);
      range.compressed = Math.max(range.compressed, -strains[frames.length - 1 - at]!);
    }
    return range;
  }

  /** Compares nodes [m], shape [N, 3], with a range; `nodes` of the answer are overwritten by the next one. */
  compare(nodes: Float32Array, range: Strains): Excess {
    const most = {
      stretched: Math.max(range.stretched, LEAST_STRAIN),
      compressed: Math.max(range.compressed, LEAST_STRAIN),
    };
    const beyond = this.#nodes.fill(0);
    let [times, way]: [number, Excess['way']] = [0, 'stretched'];
    for (let s = 0; s < this.#lengths.length; s += 1) {
      const strain = this.#strain(nodes, s);
      const share = strain > 0 ? strain / most.stretched : -strain / most.compressed;
      if (share > times) {
        times = share;
        way = strain > 0 ? 'stretched' : 'compressed';
      }
      if (share <= 1) continue;
      const value = Math.min(share - 1, 1);
      for (const node of [this.#ends[2 * s]!, this.#ends[2 * s + 1]!]) {
        if (beyond[node]! < value) beyond[node] = value;
      }
    }
    return { times, way, nodes: beyond };
  }

  /** Change of a spring's length, as a share of it. */
  #strain(nodes: Float32Array, s: number): number {
    const [a, b] = [3 * this.#ends[2 * s]!, 3 * this.#ends[2 * s + 1]!];
    const x = nodes[b]! - nodes[a]!;
    const y = nodes[b + 1]! - nodes[a + 1]!;
    const z = nodes[b + 2]! - nodes[a + 2]!;
    return Math.sqrt(x * x + y * y + z * z) / this.#lengths[s]! - 1;
  }
}
