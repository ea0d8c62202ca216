import { expect, test } from 'vitest';

import { sentence } from './text';

test('texts become sentences, names stay as they are', () => {
  expect(sentence('no camera has a mask')).toBe('No camera has a mask.');
  expect(sentence('what is it?')).toBe('What is it?');
  expect(['final_data.pkl is damaged', '`fps` is missing', 'e2e fails'].map(sentence)).toEqual([
    'final_data.pkl is damaged.',
    '`fps` is missing.',
    'e2e fails.',
  ]);
});
