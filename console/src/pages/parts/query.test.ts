import { expect, test } from 'vitest';

import { filterWords } from './query';

const STATE = { name: 'state', label: 'State', values: [['', 'all'], ['FAILED', 'failed']] } as const;

test('filters are said in words, and no filter is not', () => {
  const words = (query: Record<string, string>): string => filterWords(query, [STATE]).replace(/[\u2068\u2069]/g, '');
  expect(words({})).toBe('');
  expect(words({ state: 'FAILED' })).toBe(' with state “failed”');
  expect(words({ search: 'rope', tag: 'wet', state: 'FAILED' })).toBe(
    ' with “rope” in the name or note, tag “wet”, state “failed”',
  );
});
