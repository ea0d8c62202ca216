const FIRST_MS = 500;
const LONGEST_MS = 8000;

/** Pause before the next attempt [ms], after `failures` in a row: it doubles, and varies by a quarter. */
export function pauseMs(failures: number, random = Math.random()): number {
  const pause = Math.min(FIRST_MS * 2 ** Math.max(failures - 1, 0), LONGEST_MS);
  return pause * (0.75 + 0.5 * random);
}

/** Waits [ms]; ends early, without an error, when the signal is aborted. */
export function sleep(ms: number, signal?: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    if (signal?.aborted) return resolve();
    const done = (): void => {
      clearTimeout(timer);
      signal?.removeEventListener('abort', done);
      resolve();
    };
    const timer = setTimeout(done, ms);
    signal?.addEventListener('abort', done);
  });
}
