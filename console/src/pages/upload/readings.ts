import { hasEnded, Problem, type Capture } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { refresh } from '../../ui/refresh';
import type { Report } from '../captures/report/report';
import { verdictText } from '../captures/report/verdict';

/** Pause between two questions [ms], and captures that are asked for each time. */
const PAUSE_MS = 1500;
const AT_ONCE = 4;

/** How a capture is read: the capture, and its verdict in a sentence once there is one. */
export interface Reading {
  readonly capture: Capture;
  readonly sentence: string;
}

/**
 * Readings of captures that were uploaded here. They are asked for a few at a time: a stream of events for each would
 * take all connections that a browser has to a server.
 */
export class Readings extends EventTarget {
  readonly #all = new Map<string, Reading | null>();
  /** Captures that were deleted meanwhile. */
  readonly #gone = new Set<string>();

  constructor(private readonly context: PageContext) {
    super();
    void refresh(context, PAUSE_MS, () => this.#ask());
  }

  /** The reading of a capture (`captures/{uuid}`); null while it is not known. It is asked for from now on. */
  of(name: string): Reading | null {
    if (!this.#all.has(name)) this.#all.set(name, null);
    return this.#all.get(name) ?? null;
  }

  async #ask(): Promise<void> {
    const isOpen = (name: string, reading: Reading | null): boolean =>
      !this.#gone.has(name) && (reading === null || !hasEnded(reading.capture.ingest));
    const open = [...this.#all].filter(([name, reading]) => isOpen(name, reading)).map(([name]) => name);
    for (const name of open.slice(0, AT_ONCE)) {
      const reading = await this.#read(name);
      // What was asked for just now is asked for again after the others.
      this.#all.delete(name);
      this.#all.set(name, reading);
    }
    if (open.length > 0) this.dispatchEvent(new Event('change'));
  }

  async #read(name: string): Promise<Reading | null> {
    const { api, signal } = this.context;
    try {
      const capture = await api.json<Capture>(`/v1/${name}`, { signal });
      if (!hasEnded(capture.ingest)) return { capture, sentence: '' };
      if (!capture.verdict) return { capture, sentence: capture.ingest.fault?.message ?? '' };
      return { capture, sentence: verdictText(await api.json<Report>(`/v1/${name}/report`, { signal })) };
    } catch (error) {
      if (error instanceof Problem && error.status === 404) this.#gone.add(name);
      // Otherwise it is asked for again.
      return this.#all.get(name) ?? null;
    }
  }
}
