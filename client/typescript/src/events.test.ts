import { afterEach, describe, expect, it, vi } from 'vitest';
import { Client } from './client.js';
import { watch } from './events.js';

interface Data {
  readonly n: number;
}

function stream(...numbers: number[]): Response {
  return new Response(numbers.map((n) => `event: fit\nid: ${n}\ndata: {"n":${n}}\n\n`).join(''));
}

/** Answers of the server in order; a null is a server that is not there. */
function server(...answers: (Response | null)[]): { seen: (string | null)[] } {
  const seen: (string | null)[] = [];
  vi.stubGlobal('fetch', async (path: string, options?: RequestInit) => {
    if (path === '/healthz') return new Response('ok');
    seen.push(new Headers(options?.headers).get('last-event-id'));
    const answer = answers.shift();
    if (answer === undefined) throw new Error('nothing more was expected');
    if (answer === null) throw new TypeError('fetch failed');
    return answer;
  });
  return { seen };
}

async function follow(): Promise<number[]> {
  const read = async (): Promise<number[]> => {
    const got: number[] = [];
    for await (const { n } of watch<Data>(new Client(), '/v1/fits/1/events', { isLast: ({ n }) => n === 9 })) got.push(n);
    return got;
  };
  const reading = read();
  reading.catch(() => undefined);
  await vi.runAllTimersAsync();
  return reading;
}

describe('watch', () => {
  vi.useFakeTimers();
  afterEach(() => vi.unstubAllGlobals());

  it('resumes after the last event when the server was lost', async () => {
    const { seen } = server(stream(1, 2), null, stream(3), new Response('', { status: 503 }), stream(9));
    expect(await follow()).toEqual([1, 2, 3, 9]);
    expect(seen).toEqual([null, '2', '2', '3', '3']);
  });

  it('gives up where the server refuses', async () => {
    const problem = JSON.stringify({ status: 404, reason: 'NOT_FOUND', detail: 'there is no such fit' });
    server(stream(1), new Response(problem, { status: 404 }));
    await expect(follow()).rejects.toMatchObject({ reason: 'NOT_FOUND', message: 'there is no such fit' });
  });

  it('ends with its signal', async () => {
    server();
    const signal = AbortSignal.abort();
    const { done } = await watch<Data>(new Client(), '/x', { signal, isLast: () => false }).next();
    expect(done).toBe(true);
  });

  it('closes the stream of a reader that has enough', async () => {
    let closed = false;
    const body = new ReadableStream({
      start: (controller) => controller.enqueue(new TextEncoder().encode('id: 1\ndata: {"n":1}\n\n')),
      cancel: () => void (closed = true),
    });
    server(new Response(body));
    for await (const { n } of watch<Data>(new Client(), '/x', { isLast: () => false })) {
      expect(n).toBe(1);
      break;
    }
    expect(closed).toBe(true);
  });
});
