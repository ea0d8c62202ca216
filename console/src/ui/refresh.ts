import { sleep } from '@bendtwin/client';
import type { PageContext } from '../page';

/**
 * Calls `ask` now and again after each pause [ms], until the page is left. It rests while the window
 * is hidden and while the server does not answer. What the first call throws is thrown; later faults
 * leave what is shown.
 */
export async function refresh({ api, signal }: PageContext, ms: number, ask: () => Promise<void>): Promise<void> {
  await ask();
  void repeat();

  async function repeat(): Promise<void> {
    for (;;) {
      await sleep(ms, signal);
      await api.connection.back(signal);
      await visible(signal);
      if (signal.aborted) return;
      await ask().catch(() => undefined);
    }
  }
}

/** Resolves when the window can be seen, or when the signal is aborted. */
function visible(signal: AbortSignal): Promise<void> {
  if (!document.hidden || signal.aborted) return Promise.resolve();
  return new Promise((resolve) => {
    document.addEventListener('visibilitychange', () => resolve(), { once: true, signal });
    signal.addEventListener('abort', () => resolve(), { once: true });
  });
}
