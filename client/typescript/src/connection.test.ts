import { describe, expect, it, vi } from 'vitest';
import { pauseMs } from './backoff.js';
import { Connection } from './connection.js';

describe('Connection', () => {
  it('asks until the server answers, ever more rarely, and says so once', async () => {
    const answers = [false, false, true];
    const pauses: number[] = [];
    const said: string[] = [];
    const connection = new Connection(
      async () => answers.shift() ?? true,
      async (ms) => void pauses.push(ms),
    );
    for (const event of ['lost', 'back']) connection.addEventListener(event, () => said.push(event));
    connection.lost();
    connection.lost();
    expect(connection.isLost).toBe(true);
    await connection.back(new AbortController().signal);
    expect(connection.isLost).toBe(false);
    expect(said).toEqual(['lost', 'back']);
    expect(pauses).toHaveLength(3);
    expect(pauses[2]).toBeGreaterThan(pauses[0] ?? 0);
  });

  it('does not keep one waiting who gave up, and asks no longer', async () => {
    let ended = false;
    const pause = (_ms: number, signal: AbortSignal): Promise<void> =>
      new Promise((resolve) => signal.addEventListener('abort', () => resolve(void (ended = true))));
    const connection = new Connection(async () => true, pause);
    const left = new AbortController();
    connection.lost();
    const back = connection.back(left.signal);
    left.abort();
    await back;
    expect([connection.isLost, ended]).toEqual([true, true]);
  });

  it('asks nothing while nobody waits, and learns from any answer', async () => {
    const probe = vi.fn(async () => true);
    const connection = new Connection(probe, async () => undefined);
    connection.lost();
    connection.answered();
    expect([connection.isLost, probe.mock.calls.length]).toEqual([false, 0]);
    await connection.back();
  });

  it('asks again for one who waits after another gave up', async () => {
    const connection = new Connection(async () => true, async () => undefined);
    const left = new AbortController();
    connection.lost();
    const first = connection.back(left.signal);
    left.abort();
    await Promise.all([first, connection.back()]);
    expect(connection.isLost).toBe(false);
  });
});

it('pauses double and end at some seconds', () => {
  expect([1, 2, 3, 10].map((failures) => pauseMs(failures, 0.5))).toEqual([500, 1000, 2000, 8000]);
});
