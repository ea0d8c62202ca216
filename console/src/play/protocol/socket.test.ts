import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { PlaySocket, type SocketListener } from './socket';

/** A WebSocket whose other side is the test. */
class FakeSocket extends EventTarget {
  static all: FakeSocket[] = [];
  binaryType = 'blob';
  readonly sent: string[] = [];
  constructor(
    readonly url: URL,
    readonly protocols: string[],
  ) {
    super();
    FakeSocket.all.push(this);
  }
  send(text: string): void {
    this.sent.push(text);
  }
  close(): void {
    this.dispatchEvent(new Event('close'));
  }
  opens(): void {
    this.dispatchEvent(new Event('open'));
  }
  says(message: object): void {
    this.dispatchEvent(new MessageEvent('message', { data: JSON.stringify(message) }));
  }
}

const told: string[] = [];
const listener: SocketListener = {
  begin: () => ({ fast: false }),
  text: (text) => void told.push(text.type),
  state: () => void told.push('state'),
  lost: () => void told.push('lost'),
  ended: (problem) => void told.push(`ended ${problem?.reason}`),
};

describe('PlaySocket', () => {
  let left: AbortController;
  const server = { lost: vi.fn(), back: vi.fn(() => Promise.resolve()) };
  const open = (): PlaySocket => new PlaySocket('/v1/twins/1/play', listener, server, left.signal);
  const last = (): FakeSocket => FakeSocket.all.at(-1)!;

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal('WebSocket', FakeSocket);
    vi.stubGlobal('location', { href: 'https://server/#/' });
    vi.stubGlobal('sessionStorage', { getItem: () => 'secret' });
    FakeSocket.all = [];
    told.length = 0;
    left = new AbortController();
    vi.clearAllMocks();
  });
  afterEach(() => {
    left.abort();
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it('shows the token, begins, and sends nothing before the play is ready', () => {
    const socket = open();
    expect([last().url.href, ...last().protocols]).toEqual([
      'wss://server/v1/twins/1/play', 'bendtwin.play.v1', 'bendtwin.token', 'secret',
    ]);
    expect(socket.send({ type: 'reset' })).toBe(false);
    last().opens();
    last().says({ type: 'ready' });
    expect(socket.send({ type: 'reset' })).toBe(true);
    expect(last().sent).toEqual(['{"type":"begin","fast":false}', '{"type":"reset"}']);
  });

  it('opens another one when the server is back', async () => {
    open();
    last().opens();
    last().says({ type: 'ready' });
    last().close();
    await vi.runAllTimersAsync();
    expect([FakeSocket.all.length, server.lost.mock.calls.length]).toEqual([2, 1]);
    last().opens();
    last().says({ type: 'ready' });
    expect(told).toEqual(['ready', 'lost', 'ready']);
  });

  it('reconnects after the farewell of a stopping server, and after no other', async () => {
    open();
    last().says({ type: 'ended', problem: { reason: 'STOPPING', detail: '' } });
    last().close();
    await vi.runAllTimersAsync();
    expect(FakeSocket.all).toHaveLength(2);
    last().says({ type: 'ended', problem: { reason: 'PLAY_IDLE', detail: '' } });
    last().close();
    await vi.runAllTimersAsync();
    expect([FakeSocket.all.length, told.at(-1)]).toEqual([2, 'ended PLAY_IDLE']);
  });

  it('gives up where there is nothing to open', async () => {
    open();
    for (let attempt = 0; attempt < 20 && !told.includes('ended '); attempt += 1) {
      last().close();
      await vi.runAllTimersAsync();
    }
    expect(FakeSocket.all.length).toBeLessThan(10);
    expect(told.filter((text) => text === 'ended ')).toHaveLength(1);
  });

  it('ends when the page is left', async () => {
    open();
    left.abort();
    await vi.runAllTimersAsync();
    expect([FakeSocket.all.length, told]).toEqual([1, []]);
  });
});
