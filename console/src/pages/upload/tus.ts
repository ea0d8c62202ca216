import { pauseMs, Problem, ServerLost, sleep } from '@bendtwin/client';
import type { Api } from '../../api/client';

/** Bytes per request, at first and at most. */
const FIRST_BYTES = 2 ** 20;
const MOST_BYTES = 32 * 2 ** 20;
/** Time that sending a part should take, so that progress is seen and little is lost [ms]. */
const PART_MS = 1000;
/** Statuses that pass: no token yet, timeouts, a wrong offset, a sender that is still being ended, full queues. */
const PASSING = [401, 408, 409, 423, 429, 503, 504];

/** Statuses of an upload that no longer exists. */
const GONE = [404, 410];

/** A resumable upload by the tus protocol. */
export interface Upload {
  readonly content: Blob;
  /** `request_id` among it finds an upload again that was begun before. */
  readonly metadata: Readonly<Record<string, string>>;
  readonly signal: AbortSignal;
  /** Called with every offset that the server has on disk [bytes]. */
  readonly onOffset: (offset: number) => void;
  /** Called with the upload's address. */
  readonly onAddress: (address: string) => void;
  /** Called when the server cannot be reached or is busy, and with null when the upload resumes. */
  readonly onWaiting: (why: Error | null) => void;
}

/** The files have changed or are gone since they were chosen. */
export class FilesChanged extends Error {
  constructor() {
    super('The files changed since they were chosen, or cannot be read: choose them again.');
  }
}

/** Outcome of an upload. */
export interface Sent {
  /** `captures/{uuid}` */
  readonly capture: string;
  /** True if the server had all of it before anything was sent. */
  readonly wasThere: boolean;
}

/**
 * Sends all of an upload, from the server's offset on, and returns the capture. Resumes after
 * interruptions until the signal is aborted; throws permanent refusals of the server.
 */
export async function send(api: Api, upload: Upload): Promise<Sent> {
  const { signal, onWaiting } = upload;
  let address: string | null = null;
  let failures = 0;
  let sent = 0;
  let isAnew = false;
  let hasSent = false;
  const onOffset = (offset: number): void => upload.onOffset((sent = offset));
  for (;;) {
    try {
      address ??= await create(api, upload);
      const capture = await sendParts(api, { ...upload, onOffset }, address, () => {
        if (failures > 0) onWaiting(null);
        failures = 0;
        hasSent ||= sent < upload.content.size;
      });
      return { capture, wasThere: !hasSent };
    } catch (error) {
      signal.throwIfAborted();
      // One that was given up meanwhile, as after a long time without a server, is begun again, once.
      const isGone = error instanceof Problem && GONE.includes(error.status) && address !== null && !isAnew;
      if (isGone) [address, isAnew] = [null, true];
      else if (!isPassing(error)) throw error;
      failures += 1;
      onWaiting(error as Error);
      if (error instanceof ServerLost) await checkReadable(upload.content.slice(sent, sent + MOST_BYTES));
      await api.connection.back(signal);
      await sleep(pauseMs(failures), signal);
      signal.throwIfAborted();
    }
  }
}

/** Gives an upload up, so that the server keeps nothing of it. */
export async function terminate(api: Api, address: string): Promise<void> {
  await api.fetch(address, { method: 'DELETE', headers: { 'tus-resumable': '1.0.0' } });
}

async function create(api: Api, { content, metadata, signal, onAddress }: Upload): Promise<string> {
  const headers = {
    'tus-resumable': '1.0.0',
    'upload-length': String(content.size),
    'upload-metadata': Object.entries(metadata)
      .map(([key, value]) => `${key} ${base64(value)}`)
      .join(','),
  };
  // Not ended by the signal: the server would keep an upload whose address nobody knows.
  const answer = await api.fetch('/v1/uploads', { method: 'POST', headers });
  const address = answer.headers.get('location') ?? '';
  if (signal.aborted) await terminate(api, address);
  signal.throwIfAborted();
  onAddress(address);
  return address;
}

async function sendParts(api: Api, upload: Upload, address: string, onAnswer: () => void): Promise<string> {
  const { content, signal, onOffset } = upload;
  let bytes = FIRST_BYTES;
  let answer = await api.fetch(address, { method: 'HEAD', headers: { 'tus-resumable': '1.0.0' }, signal });
  for (;;) {
    const offset = Number(answer.headers.get('upload-offset'));
    onOffset(offset);
    onAnswer();
    const capture = answer.headers.get('bendtwin-capture');
    if (capture !== null) return capture;
    const began = performance.now();
    answer = await api.fetch(address, {
      method: 'PATCH',
      headers: {
        'tus-resumable': '1.0.0',
        'upload-offset': String(offset),
        'content-type': 'application/offset+octet-stream',
      },
      body: content.slice(offset, offset + bytes),
      signal,
    });
    bytes = nextPart(bytes, performance.now() - began);
  }
}

/** Size of the next part, after one of `bytes` took `ms`: at most twice or half as much. */
export function nextPart(bytes: number, ms: number): number {
  const factor = Math.min(Math.max(PART_MS / Math.max(ms, 1), 0.5), 2);
  return Math.round(Math.min(Math.max(bytes * factor, FIRST_BYTES / 16), MOST_BYTES));
}

function isPassing(error: unknown): boolean {
  return error instanceof ServerLost || (error instanceof Problem && PASSING.includes(error.status));
}

/** A file that cannot be read looks to a browser's request like a lost connection. */
async function checkReadable(part: Blob): Promise<void> {
  try {
    await part.arrayBuffer();
  } catch {
    throw new FilesChanged();
  }
}

/** UTF-8 as Base64. */
function base64(text: string): string {
  return btoa(String.fromCharCode(...new TextEncoder().encode(text)));
}
