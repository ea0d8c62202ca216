/** Speeds of playing, as factors of the recording's. */
export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4] as const;

/** The displayed frame, and how it advances. */
export class Clock {
  #frame: number;
  /** Part of a frame that has passed since the shown one began. */
  #passed = 0;
  #last: number | null = null;
  #isPlaying = false;
  speed = 1;

  constructor(
    readonly frameCount: number,
    readonly fps: number,
    frame: number,
    private readonly changed: () => void,
  ) {
    this.#frame = this.#held(frame);
  }

  get frame(): number {
    return this.#frame;
  }

  get isPlaying(): boolean {
    return this.#isPlaying;
  }

  /** Plays on, from the start if the end is shown. */
  play(): void {
    if (this.#frame === this.frameCount - 1) this.#frame = 0;
    this.#isPlaying = this.frameCount > 1;
    this.#last = null;
    this.#passed = 0;
    this.changed();
  }

  pause(): void {
    if (!this.#isPlaying) return;
    this.#isPlaying = false;
    this.changed();
  }

  /** Shows another frame, the first or last if it is beyond them. */
  seek(frame: number): void {
    const held = this.#held(frame);
    this.#passed = 0;
    if (held === this.#frame) return;
    this.#frame = held;
    this.changed();
  }

  /** Goes some frames on or back, and stops. */
  step(frames: number): void {
    this.pause();
    this.seek(this.#frame + frames);
  }

  /** Lets time pass until `now` [ms]. While `isHere` says no, the frame that is shown stays. */
  tick(now: number, isHere: (frame: number) => boolean): void {
    const elapsed = this.#last === null ? 0 : Math.max(now - this.#last, 0) / 1000;
    this.#last = now;
    if (!this.#isPlaying) return;
    this.#passed += elapsed * this.fps * this.speed;
    const whole = Math.floor(this.#passed);
    if (whole === 0) return;
    const next = this.#held(this.#frame + whole);
    if (!isHere(next)) {
      // What was waited for is not caught up with.
      this.#passed = 1;
      return;
    }
    this.#passed -= whole;
    this.#frame = next;
    if (next === this.frameCount - 1) this.#isPlaying = false;
    this.changed();
  }

  #held(frame: number): number {
    const whole = Number.isFinite(frame) ? Math.round(frame) : 0;
    return Math.min(Math.max(whole, 0), this.frameCount - 1);
  }
}
