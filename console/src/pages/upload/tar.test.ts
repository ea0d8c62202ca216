import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { describe, expect, test } from 'vitest';

import { sizeField, tar } from './tar';

const LONG = `${'deep/'.repeat(60)}${'n'.repeat(140)}.png`;
const FILES = [
  { path: 'rope/metadata.json', file: new Blob(['{}']) },
  { path: 'rope/empty.npy', file: new Blob([]) },
  { path: `${'a'.repeat(60)}/${'b'.repeat(60)}/0.png`, file: new Blob(['x'.repeat(512)]) },
  { path: 'rope/Schnüre/0.png', file: new Blob(['ü']) },
  { path: LONG, file: new Blob(['long']) },
];

describe('tar', () => {
  test('is read by another program, with every name and content', async () => {
    const folder = mkdtempSync(join(tmpdir(), 'tar-'));
    try {
      writeFileSync(join(folder, 'a.tar'), new Uint8Array(await tar(FILES).arrayBuffer()));
      execFileSync('tar', ['xf', 'a.tar'], { cwd: folder, env: { ...process.env, LC_ALL: 'C.UTF-8' } });
      for (const { path, file } of FILES) {
        expect(readFileSync(join(folder, path), 'utf8')).toBe(await file.text());
      }
    } finally {
      rmSync(folder, { recursive: true });
    }
  });

  test('gives the same bytes again', async () => {
    const [first, second] = await Promise.all([tar(FILES).text(), tar(FILES).text()]);
    expect(first).toBe(second);
  });

  test('writes sizes of 8 GiB and more as binary numbers', () => {
    expect([...sizeField(8 ** 11 + 513)]).toEqual([0x80, 0, 0, 0, 0, 0, 0, 2, 0, 0, 2, 1]);
    expect(new TextDecoder().decode(sizeField(8 ** 11 - 1))).toBe('77777777777\0');
  });
});
