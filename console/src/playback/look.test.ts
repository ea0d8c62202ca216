import { describe, expect, it } from 'vitest';
import { readLook, usual, writeLook } from './look';

describe('a look', () => {
  it('is read from an address as it was written', () => {
    const look = { ...usual(), colour: 'error' as const, beside: true, observed: false };
    const query = new URLSearchParams();
    writeLook(look, query);
    expect(query.toString()).toBe('colour=error&observed=0&beside=1');
    expect(readLook(query, true)).toEqual(look);
  });

  it('is the usual one where the address is wrong', () => {
    expect(readLook(new URLSearchParams('colour=own&observed=yes'), false)).toEqual(usual());
  });
});
