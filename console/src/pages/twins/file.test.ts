import { expect, test } from 'vitest';

import type { Api } from '../../api/client';
import { readTwinFile, spreadOf } from './file';

/** A file as a twin's, with one tensor. */
function fileOf(document: unknown, floats: readonly number[]): Uint8Array {
  const data = new Uint8Array(Float32Array.from(floats).buffer);
  const header = JSON.stringify({
    __metadata__: { 'bendtwin.twin': JSON.stringify(document) },
    'springs.stiffness': { dtype: 'F32', shape: [floats.length], data_offsets: [0, data.length] },
    'springs.ends': { dtype: 'U32', shape: [0, 2], data_offsets: [data.length, data.length] },
  });
  const bytes = new TextEncoder().encode(header);
  const file = new Uint8Array(8 + bytes.length + data.length);
  new DataView(file.buffer).setBigUint64(0, BigInt(bytes.length), true);
  file.set(bytes, 8);
  file.set(data, 8 + bytes.length);
  return file;
}

/** A server of a file, with ranges or without. */
function serving(file: Uint8Array, hasRanges: boolean): Api {
  const fetch = async (_path: string, { headers }: RequestInit): Promise<Response> => {
    const [, from, to] = /bytes=(\d+)-(\d+)/.exec((headers as Record<string, string>)['range'] ?? '') ?? [];
    if (!hasRanges) return new Response(file.slice());
    return new Response(file.slice(Number(from), Number(to) + 1), { status: 206 });
  };
  return { fetch } as unknown as Api;
}

test.each([true, false])('document and tensors of a file are read (ranges: %s)', async (hasRanges) => {
  const file = fileOf({ drag: 0.5, provenance: { settings: { seed: 7 } } }, [3, 1, 2]);
  const read = await readTwinFile(serving(file, hasRanges), '1', new AbortController().signal);
  expect(read.document.provenance?.settings).toEqual({ seed: 7 });
  expect([...(await read.floats('springs.stiffness'))]).toEqual([3, 1, 2]);
  expect(await read.floats('springs.ends')).toHaveLength(0);
  expect(await read.floats('another')).toHaveLength(0);
});

test('the spread of values is their median and the range of nine in ten', () => {
  expect(spreadOf(Float32Array.from({ length: 101 }, (_, index) => 100 - index))).toEqual({
    low: 5,
    median: 50,
    high: 95,
  });
  expect(spreadOf(new Float32Array())).toBeNull();
});
