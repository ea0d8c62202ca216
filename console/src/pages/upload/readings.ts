import { hasEnded, type Capture } from '../../api/types';
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
    const open = [...this.#all].filter(([, reading]) => reading === null || !hasEnded(reading.capture.ingest)).map(([name]) => name);
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
    } catch {
      // It is asked for again; one that was deleted meanwhile stays as it was.
      return this.#all.get(name) ?? null;
    }
  }
}
