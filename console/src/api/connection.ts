import { pauseMs, sleep } from './backoff';

/** No answer came: the server was ended, or the network is interrupted. */
export class ServerLost extends Error {
  constructor() {
    super('The server does not answer.');
  }
}

/**
 * State of the connection: whether the server answers. Once a request got no answer, the server is
 * asked until it answers. Events: `lost` and `back`.
 */
export class Connection extends EventTarget {
  #isLost = false;

  /** `probe` says whether the server answers now. */
  constructor(
    private readonly probe: () => Promise<boolean>,
    private readonly wait: (ms: number) => Promise<void> = sleep,
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
    void this.search();
  }

  /** Resolves when the server answers, or when the signal is aborted. */
  back(signal: AbortSignal): Promise<void> {
    if (!this.#isLost || signal.aborted) return Promise.resolve();
    return new Promise((resolve) => {
      this.addEventListener('back', () => resolve(), { once: true, signal });
      signal.addEventListener('abort', () => resolve(), { once: true });
    });
  }

  private async search(): Promise<void> {
    for (let failures = 1; ; failures += 1) {
      await this.wait(pauseMs(failures));
      if (await this.probe()) break;
    }
    this.#isLost = false;
    this.dispatchEvent(new Event('back'));
  }
}
