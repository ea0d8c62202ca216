import { expect, test } from 'vitest';
import { pieces } from './guide';

test('references to the guide are found, with backticks and without', () => {
  expect(pieces('there are no masks: see docs/use/cameras.md#masks.')).toEqual([
    { text: 'there are no masks: see ' },
    { section: 'masks' },
    { text: '.' },
  ]);
  expect(pieces('`docs/use/cameras.md#time` and `docs/use/cameras.md`')).toEqual([
    { section: 'time' },
    { text: ' and ' },
    { section: '' },
  ]);
});

test('other texts stay as they are', () => {
  for (const text of ['', '`code` and docs/use/captures.md#masks', 'docs/use/cameras.m', '`docs/use/`']) {
    expect(pieces(text)).toEqual(text === '' ? [] : [{ text }]);
  }
  // Markup behind the mark is text, not a part of an address.
  expect(pieces('docs/use/cameras.md#"><img>')).toEqual([{ section: '' }, { text: '#"><img>' }]);
});
