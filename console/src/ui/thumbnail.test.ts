import { expect, test, vi } from 'vitest';

import type { Api } from '../api/client';
import { Pictures } from './thumbnail';

/** An API that answers on request of the test. */
class Server {
  readonly asked: string[] = [];
  readonly #answers: ((answer: Response | Error) => void)[] = [];

  readonly fetch: Api['fetch'] = (path) => {
    this.asked.push(path);
    return new Promise((resolve, reject) =>
      this.#answers.push((answer) => (answer instanceof Error ? reject(answer) : resolve(answer))),
    );
  };

  answer(answer: Response | Error = new Response('picture')): void {
    this.#answers.shift()?.(answer);
  }
}

function pictures(): { server: Server; all: Pictures; abort: AbortController } {
  const [server, abort] = [new Server(), new AbortController()];
  return { server, all: new Pictures(server, abort.signal), abort };
}

test('a picture is fetched once, and known afterwards', async () => {
  const { server, all } = pictures();
  expect(all.peek('/a')).toBeUndefined();
  const both = [all.load('/a'), all.load('/a')];
  server.answer();
  const [first, second] = await Promise.all(both);
  expect(first).toMatch(/^blob:/);
  expect([second, all.peek('/a')]).toEqual([first, first]);
  expect(server.asked).toEqual(['/a']);
});

test('one that does not exist is not asked for again', async () => {
  const { server, all } = pictures();
  const missing = all.load('/a');
  server.answer(new Error('404'));
  expect(await missing).toBeNull();
  expect(await all.load('/a')).toBeNull();
  expect(server.asked).toEqual(['/a']);
});

test('a few are fetched together, the others in their order', async () => {
  const { server, all } = pictures();
  const loads = Array.from({ length: 6 }, (_, index) => all.load(`/${index}`));
  expect(server.asked).toEqual(['/0', '/1', '/2', '/3']);
  server.answer(new Error('404'));
  await loads[0];
  expect(server.asked).toEqual(['/0', '/1', '/2', '/3', '/4']);
  for (let index = 1; index < 6; index += 1) {
    server.answer();
    await loads[index];
  }
  expect(server.asked).toHaveLength(6);
});

test('all are released with their page', async () => {
  const { server, all, abort } = pictures();
  const release = vi.spyOn(URL, 'revokeObjectURL');
  const [kept, late] = [all.load('/a'), all.load('/b')];
  server.answer();
  const address = await kept;
  abort.abort();
  server.answer();
  expect(await late).toBeNull();
  expect(release.mock.calls).toEqual([[address]]);
  release.mockRestore();
});
