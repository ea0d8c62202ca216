import { Problem } from '@bendtwin/client';
import { beforeEach, expect, test, vi } from 'vitest';

import type { Api } from '../../api/client';
import { fingerprint, fingerprintOf } from './fingerprint';
import { kept } from './kept';
import type { Package } from './select';
import { Transfers, type Transfer } from './transfers';

/** A storage that is forgotten with the test. */
function storage(): Storage {
  const values = new Map<string, string>();
  const getItem = (key: string): string | null => values.get(key) ?? null;
  return { getItem, setItem: (key: string, value: string) => void values.set(key, value) } as unknown as Storage;
}

/** A server that takes whole uploads; `refuses` answers each with a refusal. */
class Server {
  refuses = false;
  /** Never answers to a part. */
  hangs = false;
  requests: string[] = [];
  metadata: string[] = [];
  labels: unknown[] = [];
  readonly connection = { back: () => Promise.resolve() };

  fetch(path: string, { method, headers, signal }: RequestInit): Promise<Response> {
    this.requests.push(`${method} ${path}`);
    if (this.refuses) throw new Problem(413, 'CAPTURE_TOO_LARGE', 'too large', null);
    if (method === 'POST') this.metadata.push((headers as Record<string, string>)['upload-metadata'] ?? '');
    const reply = new Headers({ location: '/v1/uploads/1', 'upload-offset': '0' });
    if (method === 'PATCH' && this.hangs) {
      return new Promise((_resolve, reject) =>
        signal?.addEventListener('abort', () => reject(new DOMException('', 'AbortError'))),
      );
    }
    if (method === 'PATCH') reply.set('bendtwin-capture', 'captures/1');
    return Promise.resolve(new Response(null, { headers: reply }));
  }

  send(method: string, path: string, body: unknown): Promise<unknown> {
    this.labels.push([method, path, body]);
    return Promise.resolve({});
  }
}

const LABELS = { name: 'rope', texts: { recorded_by: 'Ada' }, note: 'wet', tags: ['a'] };
const FILE: Package = { kind: 'file', name: 'rope', file: new File(['PK'], 'rope.zip', { lastModified: 5 }) };

function begun(server: Server): Transfers {
  return new Transfers(server as unknown as Api);
}

/** The first upload, once it is in a state. */
function until(transfers: Transfers, state: Transfer['state']): Promise<Transfer | undefined> {
  return vi.waitUntil(() => transfers.all.find((own) => own.state === state));
}

beforeEach(() => vi.stubGlobal('localStorage', storage()));

test('an upload ends as a capture with its labels, and is forgotten', async () => {
  const server = new Server();
  const transfers = begun(server);
  transfers.add(FILE, LABELS, '');
  expect(kept()).toMatchObject([{ name: 'rope', source: 'rope.zip', kind: 'file', sizeBytes: 2 }]);
  expect(await until(transfers, 'stored')).toMatchObject({ capture: 'captures/1', offset: 2 });
  expect(server.metadata[0]).toContain(`recorded_by ${btoa('Ada')}`);
  expect(server.labels).toEqual([['PATCH', '/v1/captures/1', { note: 'wet', add_tags: ['a'] }]]);
  expect(kept()).toEqual([]);
  transfers.remove(transfers.all[0]?.id ?? 0);
  expect(transfers.all).toEqual([]);
});

test('an interrupted one resumes when its files are chosen again', async () => {
  const server = new Server();
  server.hangs = true;
  const before = begun(server);
  before.add(FILE, LABELS, '{"spacing_m":0.004}');
  await vi.waitUntil(() => server.requests.some((request) => request.startsWith('PATCH')));
  // The page is opened again: nothing is left of it but what the browser keeps.
  server.hangs = false;
  const after = begun(server);
  expect(after.interrupted).toMatchObject([{ name: 'rope', address: '/v1/uploads/1' }]);
  const again: Package = { kind: 'file', name: 'rope', file: new File(['PK'], 'rope.zip', { lastModified: 5 }) };
  after.add(again, { name: 'another', texts: {}, note: '', tags: [] }, '');
  expect(await until(after, 'stored')).toMatchObject({ name: 'rope' });
  expect(server.metadata[1]).toBe(server.metadata[0]);
  expect(after.interrupted).toEqual([]);
});

test('other files, names and settings are other uploads, the same ones are not sent twice', async () => {
  const server = new Server();
  server.hangs = true;
  const transfers = begun(server);
  const changed: Package = { kind: 'file', name: 'rope', file: new File(['PK'], 'rope.zip', { lastModified: 6 }) };
  for (const source of [FILE, FILE, changed]) transfers.add(source, LABELS, '');
  expect(transfers.all).toHaveLength(2);
  await vi.waitUntil(() => server.metadata.length === 2);
  expect(new Set(server.metadata).size).toBe(2);
});

test('the request id tells which fact a text is, and stays where there is none', async () => {
  const server = new Server();
  server.hangs = true;
  const ids = async (texts: Record<string, string>): Promise<string> => {
    localStorage.setItem('bendtwin.uploads', '[]');
    const count = server.metadata.length;
    begun(server).add(FILE, { ...LABELS, texts }, '');
    await vi.waitUntil(() => server.metadata.length > count);
    const id = /request_id (\S+?)(,|$)/.exec(server.metadata[count] ?? '');
    return atob(id?.[1] ?? '');
  };
  const files = fingerprintOf([{ path: 'rope.zip', size: 2, lastModified: 5 }]);
  expect(await ids({})).toBe(`console-${fingerprint(JSON.stringify([files, 'rope', '']))}`);
  expect(await ids({ recorded_by: 'Ada' })).not.toBe(await ids({ another: 'Ada' }));
});

test('a cancelled one is given up here and at the server', async () => {
  const server = new Server();
  server.hangs = true;
  const transfers = begun(server);
  transfers.add(FILE, LABELS, '');
  await vi.waitUntil(() => server.requests.some((request) => request.startsWith('PATCH')));
  transfers.cancel(transfers.all[0]?.id ?? 0);
  expect(transfers.all[0]?.state).toBe('cancelled');
  expect(server.requests.at(-1)).toBe('DELETE /v1/uploads/1');
  expect(kept()).toEqual([]);
});

test('an upload that an older page began resumes', () => {
  const { texts: _, ...older } = { ...LABELS, files: 'f', source: 'rope.zip', kind: 'file', ingest: '', sizeBytes: 2 };
  localStorage.setItem('bendtwin.uploads', JSON.stringify([older]));
  expect(kept()).toEqual([{ ...older, texts: {} }]);
});

test('a refused one says why, and entries of other versions are ignored', async () => {
  const other = { ...LABELS, files: 'f', source: 'rope.zip', kind: 'file', ingest: '', sizeBytes: 2 };
  const wrong = [{ files: 3 }, null, 'x', { ...other, texts: null }, { ...other, texts: { recorded_by: 7 } }];
  localStorage.setItem('bendtwin.uploads', JSON.stringify(wrong));
  const server = new Server();
  server.refuses = true;
  const transfers = begun(server);
  expect(transfers.interrupted).toEqual([]);
  transfers.add(FILE, LABELS, '');
  expect(await until(transfers, 'failed')).toMatchObject({ error: { reason: 'CAPTURE_TOO_LARGE' } });
  expect(transfers.isBusy).toBe(false);
  localStorage.setItem('bendtwin.uploads', '{');
  expect(kept()).toEqual([]);
});
