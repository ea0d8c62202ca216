/** Most pixels of the canvas for one of the page, and the least share of them while things move. */
const MOST_RATIO = 2;
const LEAST_SHARE = 0.5;
/** Time between two frames above which fewer pixels are drawn [ms], and the frames that it is measured over. */
const SLOW_MS = 24;
const FRAMES = 6;

/**
 * Pixels of a picture: fewer while things move and the machine draws too slowly, all of them as soon as
 * things stand still.
 */
export class Sharpness {
  #share = 1;
  #times: number[] = [];
  #last: number | null = null;

  /** A smooth picture has as many pixels as the page at least: its edges are blended instead. */
  constructor(private readonly isSmooth = false) {}

  /** True if the picture has all of its pixels. */
  get isFull(): boolean {
    return this.#share === 1;
  }

  /** Pixels of the canvas per pixel of the page, for a screen with this ratio. */
  ratio(screen: number): number {
    const all = Math.min(Math.max(screen, 0.5), MOST_RATIO);
    return this.isSmooth ? Math.max(all * this.#share, Math.min(all, 1)) : all * this.#share;
  }

  /** Notes a frame [ms], after which another one follows if things move; true if the canvas has another size now. */
  next(now: number, moves: boolean): boolean {
    if (!moves) return this.restore();
    if (this.#last !== null) this.#times.push(now - this.#last);
    this.#last = now;
    if (this.#times.length < FRAMES) return false;
    const middle = this.#times.sort((a, b) => a - b)[FRAMES >> 1]!;
    this.#times = [];
    if (middle < SLOW_MS || this.#share <= LEAST_SHARE) return false;
    this.#share = Math.max(LEAST_SHARE, this.#share * 0.75);
    return true;
  }

  /** Draws all pixels again; true if that is another size. */
  restore(): boolean {
    const changes = this.#share !== 1;
    this.#share = 1;
    this.#times = [];
    this.#last = null;
    return changes;
  }
}
