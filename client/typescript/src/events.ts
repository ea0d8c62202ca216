import { pauseMs, sleep } from './backoff.js';
import type { Client } from './client.js';
import { ServerLost } from './connection.js';
import { Problem } from './problem.js';
import { messages } from './sse.js';

export interface WatchOptions<T> {
  /** Ends the watch. */
  readonly signal?: AbortSignal;
  /** True of the last data that there will be. */
  readonly isLast: (data: T) => boolean;
}

/**
 * The data of server-sent events, as of `/v1/fits/{id}/events`, until the last of them or until the signal is
 * aborted. A stream that breaks off, as when the server is killed, is opened again with `Last-Event-ID`. Throws
 * the `Problem` of a request that the server refuses for good.
 */
export async function* watch<T>(client: Client, path: string, { signal, isLast }: WatchOptions<T>): AsyncGenerator<T> {
  let seen = '';
  let failures = 0;
  while (!signal?.aborted) {
    try {
      const headers = { accept: 'text/event-stream', ...(seen === '' ? {} : { 'last-event-id': seen }) };
      const answer = await client.fetch(path, signal ? { headers, signal } : { headers });
      for await (const message of messages(answer)) {
        if (signal?.aborted) return;
        failures = 0;
        seen = message.id;
        const data = JSON.parse(message.data) as T;
        yield data;
        if (isLast(data)) return;
      }
    } catch (error) {
      if (signal?.aborted) return;
      if (error instanceof TypeError) client.connection.lost();
      else if (!isPassing(error)) throw error;
    }
    failures += 1;
    await client.connection.back(signal);
    await sleep(pauseMs(failures), signal);
  }
}

/** True of faults after which trying again makes sense. */
function isPassing(error: unknown): boolean {
  return error instanceof ServerLost || (error instanceof Problem && [429, 503].includes(error.status));
}
