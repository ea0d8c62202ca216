import { expect, test } from 'vitest';

import { tokenIn } from './token';

test('a token is taken out of an address that has it', () => {
  expect(tokenIn(' abc123\n')).toBe('abc123');
  expect(tokenIn('http://127.0.0.1:7070/#/twins/1/play?token=abc123&frame=2')).toBe('abc123');
  expect(tokenIn('http://127.0.0.1:7070/#/?frame=2&token=a%2Bb')).toBe('a+b');
  expect(tokenIn('#/?token=%E0%A4%A')).toBe('%E0%A4%A');
});

test('an address without a token is none', () => {
  expect(tokenIn('http://127.0.0.1:7070/#/')).toBe('http://127.0.0.1:7070/#/');
});
