/** Share of the time between two pictures that the simulation may take, and the longest such time [s]. */
const SHARE = 0.5;
const LONGEST_S = 0.1;
/** Substeps of the first picture, whose cost is unknown. */
const FIRST = 20;
/** Pictures whose middle cost counts: a single one may have waited for another program, or for a compiler. */
const PICTURES = 5;
/** Time over which the speed is measured [s], and speed below which a simulation is too slow. */
const WINDOW_S = 1;
const SLOW = 0.9;

/** Substeps for each picture: real time, or slower where the device cannot keep up. */
export class Pace {
  /** Simulated by real time over about a second: 1 where the device keeps up. */
  speed = 1;
  #owed = 0;
  #costs: number[] = [];
  #passed = 0;
  #simulated = 0;

  /** Substeps of `dt` for a picture that comes `elapsed` after the one before [s]. */
  take(elapsed: number, dt: number): number {
    const time = Math.min(elapsed, LONGEST_S);
    const wanted = this.#owed + time / dt;
    const cost = this.#costs.toSorted((a, b) => a - b)[this.#costs.length >> 1];
    const most = cost === undefined ? FIRST : Math.max(1, (1000 * SHARE * time) / cost);
    const substeps = Math.floor(Math.min(wanted, most));
    // What cannot be caught up with is left out: the motion is slower.
    this.#owed = Math.min(wanted - substeps, 1);
    this.#passed += time;
    this.#simulated += substeps * dt;
    if (this.#passed >= WINDOW_S) {
      this.speed = Math.min(1, (this.#simulated + dt) / this.#passed);
      [this.#passed, this.#simulated] = [0, 0];
    }
    return substeps;
  }

  /** Notes the time that substeps took. */
  took(ms: number, substeps: number): void {
    // Clocks of browsers are coarse: no time at all is not believed.
    this.#costs = [...this.#costs, Math.max(ms, 0.05) / substeps].slice(-PICTURES);
  }

  /** True if the motion is clearly slower than real. */
  get isSlow(): boolean {
    return this.speed < SLOW;
  }
}
