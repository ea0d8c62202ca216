import type { Capture } from '@bendtwin/client';
import type { Api } from '../../api/client';
import { fingerprint, fingerprintOf } from './fingerprint';
import { forget, keep, kept, type Kept, type Labels } from './kept';
import type { Package } from './select';
import { tar } from './tar';
import { send, terminate, type Sent } from './tus';

/** Uploads sent concurrently; others wait for their turn. */
const AT_ONCE = 2;

export type TransferState = 'queued' | 'sending' | 'waiting' | 'stored' | 'known' | 'failed' | 'cancelled';

/** An upload on its way. */
export interface Transfer {
  readonly id: number;
  readonly name: string;
  readonly source: Package;
  readonly sizeBytes: number;
  readonly state: TransferState;
  /** Bytes that the server has on disk. */
  readonly offset: number;
  /** Rate since the upload last began or resumed [bytes/s]; null until that is known. */
  readonly rate: number | null;
  /** `captures/{uuid}` once it is stored. */
  readonly capture: string | null;
  /** Why it waits or failed. */
  readonly error: unknown;
}

/** State of an upload that only the manager knows. */
interface Job {
  shown: Transfer;
  readonly kept: Kept;
  readonly abort: AbortController;
  address: string | null;
}

/**
 * Uploads of this page, which continue while people look at other pages of the console. Event
 * `change` after every change of any of them.
 */
export class Transfers extends EventTarget {
  #jobs: Job[] = [];
  #count = 0;

  constructor(private readonly api: Api) {
    super();
  }

  get all(): readonly Transfer[] {
    return this.#jobs.map(({ shown }) => shown);
  }

  /** True while something is being sent. */
  get isBusy(): boolean {
    return this.#jobs.some(({ shown }) => isUnderWay(shown));
  }

  /** Uploads that did not end before the page was left, without those that have already resumed. */
  get interrupted(): readonly Kept[] {
    return kept().filter(({ files }) => !this.#jobs.some((job) => job.kept.files === files && isUnderWay(job.shown)));
  }

  /** True if an upload of these files was begun and did not end. */
  wasBegun(source: Package): boolean {
    const files = fingerprintOfPackage(source);
    return kept().some((upload) => upload.files === files);
  }

  /** Begins an upload, or resumes an interrupted one of the same files. */
  add(source: Package, labels: Labels, ingest: string): void {
    const files = fingerprintOfPackage(source);
    if (this.#jobs.some((job) => job.kept.files === files && isUnderWay(job.shown))) return;
    const known = kept().find((upload) => upload.files === files);
    const own: Kept = known ?? {
      ...labels,
      files,
      ingest,
      source: source.kind === 'file' ? source.file.name : source.name,
      kind: source.kind,
      sizeBytes: sizeOf(source),
      address: null,
    };
    this.#count += 1;
    const shown: Transfer = {
      id: this.#count,
      name: own.name,
      source,
      sizeBytes: own.sizeBytes,
      state: 'queued',
      offset: 0,
      rate: null,
      capture: null,
      error: null,
    };
    this.#jobs.push({ shown, kept: own, abort: new AbortController(), address: own.address });
    keep(own);
    this.next();
  }

  /** Stops an upload and lets the server forget it. */
  cancel(id: number): void {
    const job = this.#jobs.find(({ shown }) => shown.id === id);
    if (job === undefined || !isUnderWay(job.shown)) return;
    job.abort.abort();
    forget(job.kept.files);
    if (job.address !== null) terminate(this.api, job.address).catch(() => undefined);
    this.change(job, { state: 'cancelled', rate: null });
    this.next();
  }

  /** Takes one that has ended out of the list. */
  remove(id: number): void {
    this.#jobs = this.#jobs.filter(({ shown }) => shown.id !== id || isUnderWay(shown));
    this.dispatchEvent(new Event('change'));
  }

  /** Forgets one that was interrupted, here and at the server. */
  forget({ files, address }: Kept): void {
    forget(files);
    if (address !== null) terminate(this.api, address).catch(() => undefined);
    this.dispatchEvent(new Event('change'));
  }

  private next(): void {
    const sending = this.#jobs.filter(({ shown }) => shown.state === 'sending' || shown.state === 'waiting').length;
    const queued = this.#jobs.filter(({ shown }) => shown.state === 'queued');
    for (const job of queued.slice(0, Math.max(AT_ONCE - sending, 0))) void this.run(job);
    this.dispatchEvent(new Event('change'));
  }

  private async run(job: Job): Promise<void> {
    this.change(job, { state: 'sending' });
    try {
      const { capture, wasThere } = await this.sent(job);
      await this.label(job, capture);
      forget(job.kept.files);
      const state = wasThere ? 'known' : 'stored';
      this.change(job, { state, capture, offset: job.shown.sizeBytes, error: null });
    } catch (error) {
      // What failed stays among the interrupted ones: its files can be chosen again.
      if (!job.abort.signal.aborted) this.change(job, { state: 'failed', error, rate: null });
    }
    this.next();
  }

  private sent(job: Job): Promise<Sent> {
    const { kept: own, abort } = job;
    const source = job.shown.source;
    const content = source.kind === 'file' ? source.file : tar(inFolder(source));
    let began: { at: number; offset: number } | null = null;
    return send(this.api, {
      content,
      metadata: {
        filename: own.source,
        display_name: own.name,
        ...own.texts,
        request_id: `console-${fingerprint(JSON.stringify([own.files, own.name, own.ingest, ...Object.entries(own.texts)]))}`,
        ...(own.ingest === '' ? {} : { ingest: own.ingest }),
      },
      signal: abort.signal,
      onAddress: (address) => {
        job.address = address;
        keep({ ...own, sizeBytes: content.size, address });
        this.change(job, { sizeBytes: content.size });
      },
      onOffset: (offset) => {
        const now = performance.now();
        began ??= { at: now, offset };
        const seconds = (now - began.at) / 1000;
        this.change(job, { offset, rate: seconds > 0 ? (offset - began.offset) / seconds : null });
      },
      onWaiting: (error) => {
        began = null;
        this.change(job, { state: error === null ? 'sending' : 'waiting', error, rate: null });
      },
    });
  }

  /** Note and tags, which an upload itself does not have. */
  private async label({ kept: { note, tags }, abort }: Job, capture: string): Promise<void> {
    if (note === '' && tags.length === 0) return;
    await this.api.send<Capture>('PATCH', `/v1/${capture}`, { note, add_tags: tags }, abort.signal);
  }

  private change(job: Job, changes: Partial<Transfer>): void {
    // A cancelled upload stays so, despite answers to its last request.
    if (job.shown.state === 'cancelled') return;
    job.shown = { ...job.shown, ...changes };
    this.dispatchEvent(new Event('change'));
  }
}

export function isUnderWay({ state }: Transfer): boolean {
  return state === 'queued' || state === 'sending' || state === 'waiting';
}

/** Names in the archive begin with that of its folder. */
function inFolder({ name, files }: Package & { kind: 'folder' }): { path: string; file: File }[] {
  return files.map(({ path, file }) => ({ path: `${name}/${path}`, file }));
}

/** Bytes of what is sent, without the heads of an archive. */
export function sizeOf(source: Package): number {
  return source.kind === 'file' ? source.file.size : source.files.reduce((sum, { file }) => sum + file.size, 0);
}

/** Fingerprint of what is sent, by which it is found again. */
export function fingerprintOfPackage(source: Package): string {
  const files = source.kind === 'file' ? [{ path: source.file.name, file: source.file }] : inFolder(source);
  return fingerprintOf(files.map(({ path, file }) => ({ path, size: file.size, lastModified: file.lastModified })));
}
