import { expect, test } from 'vitest';

import { contentOf, kindOf, refusal } from './sniff';
import { tar } from './tar';

function file(name: string, bytes: readonly number[] | string): File {
  if (typeof bytes === 'string') return new File([bytes], name);
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

test('markers of motion capture are captures', async () => {
  const c3d = (block: number, processor: number): number[] => {
    const bytes = [block, 0x50, ...Array<number>(2046).fill(0)];
    bytes[512 * (block - 1) + 3] = processor;
    return bytes;
  };
  const taken = [
    file('take.csv', 'Format Version,1.23,Take Name,a'),
    file('marked.csv', '\ufeffFormat Version,1.23'),
    file('take.trc', 'PathFileType\t4\t(X/Y/Z)'),
    file('take.c3d', c3d(2, 84)),
    file('late.c3d', c3d(4, 86)),
  ];
  expect(await Promise.all(taken.map(contentOf))).toEqual(taken.map(() => 'capture'));
  const refused = [
    file('table.csv', 'x,y,z\n1,2,3'),
    file('short.c3d', [2, 0x50]),
    file('other.c3d', c3d(2, 83)),
    // The parameters would lie in the header.
    file('header.c3d', c3d(1, 84)),
    file('picture.png', [0x89, 0x50, 0x4e, 0x47]),
  ];
  expect(await Promise.all(refused.map(contentOf))).toEqual(refused.map(() => 'other'));
});

test('a document alone is refused with the place where it belongs', () => {
  expect(refusal('transforms.json', 'other')).toContain('drop the folder that it belongs to');
  expect(refusal('a.txt', 'other')).toContain('send a folder');
});

test('files that are no captures are called what they are', async () => {
  const kinds = await Promise.all([
    kindOf(file('setup.exe', 'MZ\x90')),
    kindOf(file('film.zip', [0, 0, 0, 0x20, 0x66, 0x74, 0x79, 0x70])),
    kindOf(file('photo.png', [0x89, 0x50, 0x4e, 0x47])),
    kindOf(file('nothing.zip', [])),
    kindOf(file('notes.txt', 'some text')),
  ]);
  expect(kinds).toEqual(['a Windows program', 'a video', 'an image', 'empty', null]);
  expect(refusal('setup.exe', 'other', 'a Windows program')).toMatch(/^setup\.exe is a Windows program, not a capture: send/);
});
