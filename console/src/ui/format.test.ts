import { expect, it } from 'vitest';
import { count, counted, duration, millimetres, moment, percent, size } from './format';

it('writes sizes with three digits', () => {
  expect([0, 999, 1000, 1_234_567, 999_600, 5e13].map(size)).toEqual(['0 B', '999 B', '1 kB', '1.23 MB', '1 MB', '50 TB']);
  expect(size(null)).toBe('–');
});

it('writes lengths in millimetres', () => {
  expect([0.0041337, 0.1234, 12, -0.5].map(millimetres)).toEqual(['4.13 mm', '123 mm', '12000 mm', '-500 mm']);
  expect([0, 2.39e-10].map(millimetres)).toEqual(['0 mm', '0 mm']);
  expect([null, undefined, Number.NaN].map(millimetres)).toEqual(['–', '–', '–']);
});

it('writes time spans', () => {
  expect([0.04, 9.94, 9.96, 59.6, 185, 7800, 180000].map(duration)).toEqual([
    '0.0 s',
    '9.9 s',
    '10 s',
    '1 min 0 s',
    '3 min 5 s',
    '2 h 10 min',
    '2 d 2 h',
  ]);
});

it('writes counts and shares', () => {
  expect([count(12300), counted(1, 'twin'), counted(0, 'twin'), percent(0.256)]).toEqual([
    '12,300',
    '1 twin',
    '0 twins',
    '26 %',
  ]);
});

it('leaves the date of today out', () => {
  const now = new Date(2026, 10, 24, 15, 0, 0);
  expect(moment(new Date(2026, 10, 24, 9, 5, 7).toISOString(), now)).toBe('09:05:07');
  expect(moment(new Date(2026, 10, 23, 9, 5, 7).toISOString(), now)).toBe('2026-11-23 09:05');
  expect(moment('yesterday', now)).toBe('yesterday');
});
