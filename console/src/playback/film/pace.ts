/** Least time between two pictures of a video [s]. */
const LEAST_S = 1 / 30;

/** Frames of a video, and the time for which each of them is shown. */
export interface Pace {
  readonly frames: readonly number[];
  readonly seconds: number;
}

/** Frames of a recording for a video at a speed; some are left out where they would follow too fast. */
export function paceOf(frameCount: number, fps: number, speed: number): Pace {
  const each = 1 / (fps * speed);
  const step = Math.max(Math.ceil(LEAST_S / each - 1e-6), 1);
  const frames = Array.from({ length: Math.ceil(frameCount / step) }, (_, i) => i * step);
  return { frames, seconds: step * each };
}
