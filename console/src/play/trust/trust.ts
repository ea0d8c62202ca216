import type { Api } from '../../api/client';
import type { TwinShape } from '../../view3d/shape';
import type { PlayState } from '../protocol/state';
import { recordedStrains } from './recorded';
import { LEAST_STRAIN, Material, type Excess, type Strains } from './strain';
import { TOLERATED, warningOf } from './words';

/** Time for which a warning stays at least, so that it can be read [ms]. */
const STAYS_MS = 1500;

/** Compares the states of a play with what was recorded of the object. */
export class Trust {
  /** The warning about the last states; empty without a reason for one. */
  warning = '';
  readonly #material: Material;
  #range: Strains | null = null;
  #isAsked = false;
  #worst = { times: 0, until: 0 };

  /** `ask` finds the recorded range; it is called once something is strained. */
  constructor(
    shape: TwinShape,
    private readonly ask: ((material: Material) => Promise<Strains>) | null,
  ) {
    this.#material = new Material(shape);
  }

  /** Compares with the capture of a twin; with nothing without one. */
  static of(api: Api, twin: string, shape: TwinShape, capture: string | null, signal: AbortSignal): Trust {
    if (capture === null) return new Trust(shape, null);
    return new Trust(shape, (material) => recordedStrains(api, { twin, capture, material }, signal));
  }

  /**
   * How far nodes are beyond the range in a state, shape [N], or null within it. `weights` is the largest force as a
   * multiple of the object's weight, null if this is not known.
   */
  judge(state: PlayState, weights: number | null, now = performance.now()): Float32Array | null {
    if (state.strain > LEAST_STRAIN) this.#begin();
    const excess = this.#range === null ? null : this.#material.compare(state.positions, this.#range);
    this.#warn(excess, weights, now);
    return excess !== null && excess.times > TOLERATED ? excess.nodes : null;
  }

  /** The worst of the last moments is what the warning is about. */
  #warn(excess: Excess | null, weights: number | null, now: number): void {
    const times = excess?.times ?? 0;
    if (now < this.#worst.until && times < this.#worst.times) return;
    this.#worst = { times, until: now + STAYS_MS };
    this.warning = excess === null ? '' : warningOf(excess, weights);
  }

  /** Asks for the range, once. Where it cannot be found, nothing is said about it. */
  #begin(): void {
    if (this.#isAsked || this.ask === null) return;
    this.#isAsked = true;
    this.ask(this.#material).then((range) => (this.#range = range), () => undefined);
  }
}
