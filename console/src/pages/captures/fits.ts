import type { Fit } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { count } from '../../ui/format';

/** Fits that are asked for, those with the least errors first. */
const MOST = 500;

/** An error [m] and its measure, as the API names it. */
export interface Best {
  readonly error_m: number;
  readonly measure: string | null;
}

/** Numbers of fits and least errors of all captures, by one request. */
export class Fits {
  readonly #captures = new Map<string, { count: number; best: Best | null }>();

  /** `isWhole` is true if these are all fits: their numbers are known only then. */
  constructor(
    fits: readonly Pick<Fit, 'capture' | 'error_m' | 'measure'>[],
    private readonly isWhole: boolean,
  ) {
    for (const { capture, error_m, measure } of fits) {
      const { count, best } = this.#captures.get(capture) ?? { count: 0, best: null };
      const isBetter = typeof error_m === 'number' && !(best !== null && best.error_m <= error_m);
      this.#captures.set(capture, { count: count + 1, best: isBetter ? { error_m, measure: measure ?? null } : best });
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

  /** The least error among them; null without any. */
  best(capture: string): Best | null {
    return this.#captures.get(capture)?.best ?? null;
  }
}
