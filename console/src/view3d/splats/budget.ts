/** Time between pictures above which fewer splats are drawn [ms]: 30 a second. */
const SLOW_MS = 1000 / 30;
/** Gaps above this are pauses and no slow pictures [ms]. */
const PAUSE_MS = 400;
/** Slow pictures in a row after which fewer are drawn. */
const PATIENCE = 12;
/** Share that is kept each time, and the least number. */
const KEPT = 0.75;
const LEAST = 1000;

/** Number of splats that a machine draws often enough: it only gets smaller. */
export class SplatBudget {
  #last = -Infinity;
  #slow = 0;

  constructor(private limit: number) {}

  /** The number for a picture at this time [ms]. */
  next(now: number): number {
    const gap = now - this.#last;
    this.#last = now;
    if (gap < PAUSE_MS) this.#slow = gap > SLOW_MS ? this.#slow + 1 : 0;
    if (this.#slow >= PATIENCE && this.limit > LEAST) {
      this.limit = Math.max(LEAST, Math.round(KEPT * this.limit));
      this.#slow = 0;
    }
    return this.limit;
  }
}
