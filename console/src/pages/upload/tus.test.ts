import { Problem, ServerLost } from '@bendtwin/client';
import { describe, expect, test, vi } from 'vitest';

import type { Api } from '../../api/client';
import { FilesChanged, nextPart, send } from './tus';

/** A server of one upload, which fails where the test says. */
class Server {
  stored = Buffer.alloc(0);
  created = 0;
  deleted = 0;
  metadata = '';
  /** Called before each request with its method; may throw. */
  trouble: (method: string) => void = () => undefined;
  readonly connection = { back: () => Promise.resolve() };

  constructor(private readonly length: number) {}

  async fetch(_path: string, { method, headers, body }: RequestInit): Promise<Response> {
    const given = headers as Record<string, string>;
    expect(given['tus-resumable']).toBe('1.0.0');
    if (method === 'PATCH') {
      expect(Number(given['upload-offset'])).toBe(this.stored.length);
      this.stored = Buffer.concat([this.stored, Buffer.from(await (body as Blob).arrayBuffer())]);
    }
    this.trouble(method ?? '');
    if (method === 'POST') {
      this.created += 1;
      this.metadata = given['upload-metadata'] ?? '';
    }
    if (method === 'DELETE') this.deleted += 1;
    const reply = new Headers({ location: '/v1/uploads/1', 'upload-offset': String(this.stored.length) });
    if (this.stored.length === this.length) reply.set('bendtwin-capture', 'captures/1');
    return new Response(null, { headers: reply });
  }
}

const BYTES = 3 * 2 ** 20 + 5;
const CONTENT = new Blob([new Uint8Array(BYTES).map((_, index) => index % 251)]);

function run(server: Server, content = CONTENT, signal = new AbortController().signal) {
  const waits: (Error | null)[] = [];
  const offsets: number[] = [];
  const capture = send(server as unknown as Api, {
    content,
    metadata: { request_id: 'a', display_name: 'Schnur ü' },
    signal,
    onOffset: (offset) => offsets.push(offset),
    onAddress: () => undefined,
    onWaiting: (why) => waits.push(why),
  });
  return { capture, waits, offsets };
}

describe('an upload', () => {
  test('is sent in parts', async () => {
    const server = new Server(BYTES);
    const { capture, offsets } = run(server);
    expect(await capture).toEqual({ capture: 'captures/1', wasThere: false });
    expect(server.stored.equals(Buffer.from(await CONTENT.arrayBuffer()))).toBe(true);
    expect(offsets[0]).toBe(0);
    expect(offsets.at(-1)).toBe(BYTES);
    expect(offsets.length).toBeGreaterThan(2);
    expect(server.metadata).toBe('request_id YQ==,display_name U2NobnVyIMO8');
  });

  test('resumes at the server\'s offset after an answer was lost', async () => {
    const server = new Server(BYTES);
    let lost = 0;
    server.trouble = (method) => {
      // The bytes are stored, but the reply is lost.
      if (method === 'PATCH' && (lost += 1) === 1) throw new ServerLost();
    };
    const { capture, waits } = run(server);
    expect(await capture).toEqual({ capture: 'captures/1', wasThere: false });
    expect(server.stored.equals(Buffer.from(await CONTENT.arrayBuffer()))).toBe(true);
    expect(server.created).toBe(1);
    expect(waits.map((why) => why?.constructor)).toEqual([ServerLost, undefined]);
  });

  test('of stored content sends nothing, and says so', async () => {
    const server = new Server(BYTES);
    server.stored = Buffer.alloc(BYTES);
    const methods: string[] = [];
    server.trouble = (method) => methods.push(method);
    expect(await run(server).capture).toEqual({ capture: 'captures/1', wasThere: true });
    expect(methods).toEqual(['POST', 'HEAD']);
  });

  test('waits for a token, and continues with it', async () => {
    const server = new Server(BYTES);
    let refused = 0;
    server.trouble = (method) => {
      if (method === 'POST' && (refused += 1) === 1) throw new Problem(401, 'BAD_CLIENT_TOKEN', 'missing', null);
    };
    const { capture, waits } = run(server);
    expect(await capture).toEqual({ capture: 'captures/1', wasThere: false });
    expect(waits.map((why) => why?.message)).toEqual(['missing', undefined]);
  });

  test('starts over, once, if the server has forgotten it', async () => {
    const server = new Server(BYTES);
    let heads = 0;
    server.trouble = (method) => {
      if (method === 'HEAD' && (heads += 1) === 1) throw new Problem(410, 'UPLOAD_GONE', 'expired', null);
    };
    expect(await run(server).capture).toEqual({ capture: 'captures/1', wasThere: false });
    expect(server.created).toBe(2);
    server.trouble = () => {
      throw new Problem(410, 'UPLOAD_GONE', 'expired', null);
    };
    await expect(run(server).capture).rejects.toThrow('expired');
  });

  test('ends at permanent refusals, and at changed files', async () => {
    const server = new Server(BYTES);
    server.trouble = () => {
      throw new Problem(413, 'CAPTURE_TOO_LARGE', 'too large', null);
    };
    await expect(run(server).capture).rejects.toThrow('too large');
    server.trouble = () => {
      throw new ServerLost();
    };
    const gone = new Blob(['x']);
    gone.slice = () =>
      ({ arrayBuffer: () => Promise.reject(new DOMException('', 'NotReadableError')) }) as unknown as Blob;
    await expect(run(server, gone).capture).rejects.toThrow(FilesChanged);
  });

  test('leaves nothing at the server if it is cancelled while it is created', async () => {
    const server = new Server(BYTES);
    const abort = new AbortController();
    server.trouble = (method) => {
      if (method === 'POST') abort.abort();
    };
    await expect(run(server, CONTENT, abort.signal).capture).rejects.toThrow(/abort/i);
    expect([server.created, server.deleted, server.stored.length]).toEqual([1, 1, 0]);
  });

  test('ends when it is cancelled, while it waits too', async () => {
    vi.useFakeTimers();
    const server = new Server(BYTES);
    const abort = new AbortController();
    server.trouble = () => {
      throw new ServerLost();
    };
    const { capture } = run(server, CONTENT, abort.signal);
    const ended = expect(capture).rejects.toThrow(/abort/i);
    await vi.advanceTimersByTimeAsync(10_000);
    abort.abort();
    await ended;
    vi.useRealTimers();
  });
});

test('parts grow and shrink with the time that they take', () => {
  expect(nextPart(2 ** 20, 100)).toBe(2 ** 21);
  expect(nextPart(2 ** 20, 10_000)).toBe(2 ** 19);
  expect(nextPart(32 * 2 ** 20, 10)).toBe(32 * 2 ** 20);
  expect(nextPart(2 ** 16, 60_000)).toBe(2 ** 16);
});
