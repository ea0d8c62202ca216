import { pauseMs, sleep } from './backoff.js';

/** No answer came: the server was ended, or the network is interrupted. */
export class ServerLost extends Error {
  override readonly name = 'ServerLost';

  constructor(options?: ErrorOptions) {
    super('The server does not answer.', options);
  }
}

/**
 * State of the connection: whether the server answers. After a request without an answer, the server is asked
 * until it answers, as long as somebody waits for that. Events: `lost` and `back`.
 */
export class Connection extends EventTarget {
  #isLost = false;
  #waiting = 0;
  /** Ends the search, which runs while there is one. */
  #search: AbortController | null = null;

  /** `probe` says whether the server answers now. */
  constructor(
    private readonly probe: () => Promise<boolean>,
    private readonly wait: (ms: number, signal: AbortSignal) => Promise<void> = sleep,
  ) {
    super();
  }

  get isLost(): boolean {
    return this.#isLost;
  }

  /** Notes a request without an answer. */
  lost(): void {
    if (this.#isLost) return;
    this.#isLost = true;
    this.dispatchEvent(new Event('lost'));
  }

  /** Notes an answer. */
  answered(): void {
    if (!this.#isLost) return;
    this.#isLost = false;
    this.dispatchEvent(new Event('back'));
  }

  /** Resolves when the server answers, or when the signal is aborted. */
  back(signal?: AbortSignal): Promise<void> {
    if (!this.#isLost || signal?.aborted) return Promise.resolve();
    this.#waiting += 1;
    if (this.#search === null) void this.search((this.#search = new AbortController()));
    return new Promise((resolve) => {
      const end = (): void => {
        this.removeEventListener('back', end);
        signal?.removeEventListener('abort', end);
        this.#waiting -= 1;
        if (this.#waiting === 0) this.#search?.abort();
        resolve();
      };
      this.addEventListener('back', end);
      signal?.addEventListener('abort', end);
    });
  }

  private async search(search: AbortController): Promise<void> {
    for (let failures = 1; !search.signal.aborted; failures += 1) {
      await this.wait(pauseMs(failures), search.signal);
      if (!search.signal.aborted && (await this.probe())) this.answered();
    }
    this.#search = null;
    // Somebody may have begun to wait between the end of the last wait and now.
    if (this.#isLost && this.#waiting > 0) void this.search((this.#search = new AbortController()));
  }
}
