import { expect, it } from 'vitest';
import { firstTwin } from './choices';

it('begins with the twin that has the least error, unless the address says otherwise', () => {
  const twins = [['a', null], ['b', 0.02], ['c', 0.01]].map(([id, error]) => ({ name: `twins/${id}`, error_m: error as number | null }));
  expect(firstTwin(null, twins)).toBe('c');
  expect(firstTwin('', twins)).toBe('c');
  expect(firstTwin('other', twins)).toBe('other');
  expect(firstTwin('none', twins)).toBe('none');
  expect(firstTwin(null, twins.slice(0, 1))).toBe('a');
  expect(firstTwin(null, [])).toBe('');
});
