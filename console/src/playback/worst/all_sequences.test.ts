import { expect, test } from 'vitest';

import { worstOf } from './all_sequences';

test('the worst frame is that of the sequence with the largest error of the same measure', () => {
  const all = [
    { track: { frame: 3, error: 0.01 }, chamfer: { frame: 4, error: 0.09 } },
    { track: { frame: 7, error: 0.03 } },
    { chamfer: { frame: 1, error: 0.5 } },
  ];
  expect(worstOf(all, 'track')).toEqual({ found: { sequence: 1, frame: 7, error: 0.03 }, of: 2 });
  expect(worstOf(all, 'chamfer')).toEqual({ found: { sequence: 2, frame: 1, error: 0.5 }, of: 2 });
  expect(worstOf([{}, {}], 'track')).toBeNull();
});
