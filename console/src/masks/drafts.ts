import { readStrokes, type Stroke } from './strokes';

/** Strokes that were not sent yet, kept while the tab is open, so that a step to another page loses none. */
export class Draft {
  readonly #key: string;

  constructor(
    capture: string,
    private readonly storage: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'> = sessionStorage,
  ) {
    this.#key = `bendtwin.strokes.${capture}`;
  }

  /** The strokes that were kept, or null. */
  get(): Stroke[] | null {
    try {
      const kept: unknown = JSON.parse(this.storage.getItem(this.#key) ?? 'null');
      return kept === null ? null : readStrokes({ strokes: kept });
    } catch {
      return null;
    }
  }

  keep(strokes: readonly Stroke[]): void {
    try {
      this.storage.setItem(this.#key, JSON.stringify(strokes));
    } catch {
      // Without room they are only on the page.
    }
  }

  forget(): void {
    this.storage.removeItem(this.#key);
  }
}
