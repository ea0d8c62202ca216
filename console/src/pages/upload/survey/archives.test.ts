import { deflateRawSync, gzipSync } from 'node:zlib';
import { describe, expect, test } from 'vitest';

import { tar } from '../tar';
import { listTar, listTarGz } from './tar_list';
import { listZip } from './zip';

const FILES = [
  ['toy/capture.json', '{"format":"bendtwin-capture"}'],
  [`toy/${'long'.repeat(60)}/größe.png`, 'x'.repeat(1000)],
  ['toy/empty.npy', ''],
] as const;

/** A ZIP archive of files, deflated or stored; with `wide`, sizes and places are in 64 bits. */
function zip(files: readonly (readonly [string, string])[], { method = 8, wide = false } = {}): Blob {
  const parts: Buffer[] = [];
  const directory: Buffer[] = [];
  let offset = 0;
  for (const [path, content] of files) {
    const name = Buffer.from(path);
    const data = method === 8 ? deflateRawSync(content) : Buffer.from(content);
    const head = Buffer.alloc(30);
    head.writeUInt32LE(0x04034b50, 0);
    head.writeUInt16LE(name.length, 26);
    const size = Buffer.byteLength(content);
    const extra = Buffer.alloc(wide ? 28 : 0);
    if (wide) {
      extra.writeUInt16LE(1, 0);
      extra.writeUInt16LE(24, 2);
      [size, data.length, offset].forEach((value, index) => extra.writeBigUInt64LE(BigInt(value), 4 + 8 * index));
    }
    const entry = Buffer.alloc(46);
    entry.writeUInt32LE(0x02014b50, 0);
    entry.writeUInt16LE(method, 10);
    entry.writeUInt32LE(wide ? 0xffffffff : data.length, 20);
    entry.writeUInt32LE(wide ? 0xffffffff : size, 24);
    entry.writeUInt16LE(name.length, 28);
    entry.writeUInt16LE(extra.length, 30);
    entry.writeUInt32LE(wide ? 0xffffffff : offset, 42);
    parts.push(head, name, data);
    directory.push(entry, name, extra);
    offset += head.length + name.length + data.length;
  }
  const size = directory.reduce((sum, part) => sum + part.length, 0);
  const end = Buffer.alloc(22);
  end.writeUInt32LE(0x06054b50, 0);
  end.writeUInt32LE(size, 12);
  end.writeUInt32LE(offset, 16);
  return new Blob([...parts, ...directory, end].map((part) => new Uint8Array(part)));
}

function tarred(files: readonly (readonly [string, string])[]): Blob {
  return tar(files.map(([path, content]) => ({ path, file: new Blob([content]) })));
}

async function read(blob: Blob, list: typeof listZip): Promise<{ files: [string, string | null][]; isWhole: boolean } | null> {
  const listing = await list(blob);
  if (listing === null) return null;
  const files = await Promise.all(
    listing.entries.map(async (entry): Promise<[string, string | null]> => {
      const bytes = await entry.read(10_000);
      return [entry.path, bytes === null ? null : new TextDecoder().decode(bytes)];
    }),
  );
  return { files, isWhole: listing.isWhole };
}

describe('the files of an archive', () => {
  const all = { files: FILES.map(([path, content]) => [path, content]), isWhole: true };

  test('are those of a ZIP, deflated, stored or with large numbers', async () => {
    for (const options of [{}, { method: 0 }, { wide: true }]) expect(await read(zip(FILES, options), listZip)).toEqual(all);
  });

  test('are those of a tar, also compressed', async () => {
    expect(await read(tarred(FILES), listTar)).toEqual(all);
    expect(await read(new Blob([new Uint8Array(gzipSync(await tarred(FILES).bytes()))]), listTarGz)).toEqual(all);
  });

  test('are not read beyond the limit', async () => {
    const [, long] = (await listZip(zip(FILES)))!.entries;
    expect(await long?.read(999)).toBeNull();
    expect(long?.size).toBe(1000);
  });

  test('may be cut off', async () => {
    const whole = zip(FILES);
    expect(await listZip(whole.slice(0, whole.size - 30))).toBeNull();
    expect(await listZip(new Blob(['PK\x03\x04', new Uint8Array(100_000)]))).toBeNull();
    const cut = await read(tarred(FILES).slice(0, 1024), listTar);
    expect(cut).toMatchObject({ files: [FILES[0]], isWhole: true });
    expect(await listTar(new Blob([new Uint8Array(2048).fill(65)]))).toBeNull();
    const packed = new Uint8Array(gzipSync(await tarred(FILES).bytes()));
    expect((await listTarGz(new Blob([packed.slice(0, packed.length - 12)])))?.isWhole ?? false).toBe(false);
  });

  test('that lie about their sizes are refused, not followed', async () => {
    const lying = await zip(FILES).bytes();
    const view = new DataView(lying.buffer);
    view.setUint32(lying.length - 22 + 12, 0x7fffffff, true);
    expect(await listZip(new Blob([lying]))).toBeNull();
    view.setUint32(lying.length - 22 + 12, 46, true);
    expect((await listZip(new Blob([lying])))?.entries).toEqual([]);
  });
});
