import type { Fit } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { count } from '../../ui/format';

/** Fits that are asked for, those with the least errors first. */
const MOST = 500;

/** Numbers of fits and least errors of all captures, by one request. */
export class Fits {
  readonly #captures = new Map<string, { count: number; best: number | null }>();

  /** `isWhole` is true if these are all fits: their numbers are known only then. */
  constructor(
    fits: readonly Pick<Fit, 'capture' | 'error_m'>[],
    private readonly isWhole: boolean,
  ) {
    for (const { capture, error_m } of fits) {
      const known = this.#captures.get(capture) ?? { count: 0, best: null };
      const best = error_m === null ? known.best : Math.min(known.best ?? Infinity, error_m);
      this.#captures.set(capture, { count: known.count + 1, best });
    }
  }

  static async load({ api, signal }: PageContext): Promise<Fits> {
    const query = { page_size: MOST, order_by: 'error' };
    const { fits, next_page_token } = await api.get('/v1/fits', { query, signal });
    return new Fits(fits, next_page_token === '');
  }

  /** Number of fits of a capture, for people; a dash if it is not known. */
  count(capture: string): string {
    return this.isWhole ? count(this.#captures.get(capture)?.count ?? 0) : '–';
  }

  /** The least error among them [m]; null without any. */
  best(capture: string): number | null {
    return this.#captures.get(capture)?.best ?? null;
  }
}
