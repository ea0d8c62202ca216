import { expect, test } from 'vitest';

import { contentOf, refusal } from './sniff';
import { tar } from './tar';

function file(name: string, bytes: readonly number[]): File {
  return new File([new Uint8Array(bytes)], name);
}

test('files are recognised by their content, not by their names', async () => {
  const header = '{"__metadata__":{}}';
  const twin = [header.length, 0, 0, 0, 0, 0, 0, 0, ...new TextEncoder().encode(`${header}rest`)];
  const made = [
    file('a', [0x50, 0x4b, 3, 4, 20]),
    file('b.txt', [0x1f, 0x8b, 8]),
    new File([tar([{ path: 'x', file: new Blob(['y']) }])], 'c'),
    file('d', [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30]),
    file('e', twin),
    file('motion.NPZ', [0x50, 0x4b, 3, 4]),
    file('film.zip', [0, 0, 0, 0x20, 0x66, 0x74, 0x79, 0x70]),
    // A header that is longer than the file.
    file('short.safetensors', [255, 255, 0, 0, 0, 0, 0, 0, 0x7b]),
    file('empty', []),
  ];
  const found = await Promise.all(made.map(contentOf));
  expect(found).toEqual(['capture', 'capture', 'capture', 'capture', 'twin', 'motion', 'other', 'other', 'other']);
  expect(found.map((content) => refusal('x', content) === null)).toEqual(
    found.map((c) => c === 'capture' || c === 'twin'),
  );
});
