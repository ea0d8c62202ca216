import { afterEach, describe, expect, it, vi } from 'vitest';
import { Api } from './client';
import { watch } from './events';

interface Data {
  readonly n: number;
}

function stream(...numbers: number[]): Response {
  return new Response(numbers.map((n) => `event: fit\nid: ${n}\ndata: {"n":${n}}\n\n`).join(''));
}

/** Answers of the server in order; a null is a server that is not there. */
function server(...answers: (Response | null)[]): { seen: (string | null)[] } {
  const seen: (string | null)[] = [];
  vi.stubGlobal('sessionStorage', { getItem: () => null });
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
  const got: number[] = [];
  const { signal } = new AbortController();
  const watching = watch<Data>(new Api(), '/v1/fits/1/events', {
    signal,
    onData: ({ n }) => got.push(n),
    isLast: ({ n }) => n === 9,
  });
  watching.catch(() => undefined);
  await vi.runAllTimersAsync();
  await watching;
  return got;
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

  it('ends when the page is left', async () => {
    server();
    const left = new AbortController();
    left.abort();
    await watch<Data>(new Api(), '/x', { signal: left.signal, onData: () => undefined, isLast: () => false });
  });
});
