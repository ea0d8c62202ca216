import { beforeEach, describe, expect, it, vi } from 'vitest';
import { ownToken, setToken, takeTokenFromAddress, token, tokenIn } from './token';
import { visitAddress, visitedTwin } from './visit';

const place = { hash: '', pathname: '/', origin: 'http://twin.example' };

function goTo(hash: string): void {
  place.hash = hash;
  takeTokenFromAddress();
}

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal('location', place);
  vi.stubGlobal('sessionStorage', {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
    removeItem: (key: string) => kept.delete(key),
  });
  vi.stubGlobal('history', {
    replaceState: (_: unknown, __: string, address: string) => (place.hash = address.slice(address.indexOf('#'))),
  });
});

describe('the token of an address', () => {
  it('is found in what people paste', () => {
    expect(tokenIn(' abc123\n')).toBe('abc123');
    expect(tokenIn('http://127.0.0.1:7070/#/twins/1/play?token=abc123&frame=2')).toBe('abc123');
    expect(tokenIn('http://127.0.0.1:7070/#/?frame=2&token=a%2Bb')).toBe('a+b');
    expect(tokenIn('#/?token=%E0%A4%A')).toBe('%E0%A4%A');
    expect(tokenIn('http://127.0.0.1:7070/#/')).toBe('http://127.0.0.1:7070/#/');
  });

  it('is taken out of it', () => {
    goTo('#/twins/1/play?view=2&token=secret');
    expect([place.hash, token()]).toEqual(['#/twins/1/play?view=2', 'secret']);
  });
});

describe('the key of a visit', () => {
  it('is taken out of the address and counts for this twin alone', () => {
    setToken('mine');
    goTo('#/shared/1?key=bt_1&points=AA');
    expect([place.hash, token(), ownToken()]).toEqual(['#/shared/1?points=AA', 'bt_1', 'mine']);
    goTo('#/shared/2');
    expect(token()).toBe('mine');
    goTo('#/twins/1');
    expect([visitedTwin(), token()]).toEqual([null, 'mine']);
    goTo('#/shared/1');
    expect(token()).toBe('bt_1');
  });

  it('is not taken on other pages', () => {
    goTo('#/twins/1?key=bt_1');
    expect([place.hash, token()]).toEqual(['#/twins/1?key=bt_1', null]);
  });

  it('is in the address of a link, unless none is needed', () => {
    const moment = new URLSearchParams({ points: 'A' });
    expect(visitAddress('1', 'bt_1', moment)).toBe('http://twin.example/#/shared/1?points=A&key=bt_1');
    expect(visitAddress('1', null)).toBe('http://twin.example/#/shared/1');
  });
});
