import { describe, expect, it } from 'vitest';
import { forceOf, warningOf } from './words';

describe('words about trust', () => {
  it('warn beyond the recorded range only', () => {
    expect(warningOf({ times: 1.2, way: 'stretched' }, 310)).toBe('');
    expect(warningOf({ times: 2.44, way: 'stretched' }, null)).toBe('Stretched 2.4 times beyond anything recorded: do not trust this.');
    expect(warningOf({ times: 12.3, way: 'compressed' }, 310.4)).toBe(
      'Compressed 12 times beyond anything recorded, pulled with 310 times its weight: do not trust this.',
    );
  });

  it('say a force in newtons and weights, or in weights alone', () => {
    expect(forceOf(3.14159, 0.5, true)).toBe('3.14 N, 6.3 × weight');
    expect(forceOf(31, 0.1, false)).toBe('310 × weight');
    expect(forceOf(2, 0, true)).toBe('2 N');
    expect(forceOf(2, 0, false)).toBe('2');
  });
});
