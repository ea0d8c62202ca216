import { describe, expect, it } from 'vitest';
import { pauseMs } from './backoff';
import { Connection } from './connection';

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

  it('does not keep a page waiting that was left', async () => {
    const connection = new Connection(() => new Promise<boolean>(() => undefined));
    const left = new AbortController();
    connection.lost();
    const back = connection.back(left.signal);
    left.abort();
    await back;
    expect(connection.isLost).toBe(true);
  });
});

it('pauses double and end at some seconds', () => {
  expect([1, 2, 3, 10].map((failures) => pauseMs(failures, 0.5))).toEqual([500, 1000, 2000, 8000]);
});
