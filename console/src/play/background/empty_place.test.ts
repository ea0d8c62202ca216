import { expect, it } from 'vitest';
import { clearPlace, type Labelled } from './empty_place';

const COLUMNS = 20;
const ROWS = 10;

/** An image whose pixels are as bright as their column, but for an object of 255 between two columns. */
function image(from: number, to: number): Labelled {
  const labels = new Uint8Array(COLUMNS * ROWS);
  const pixels = new Uint8ClampedArray(4 * COLUMNS * ROWS);
  for (let i = 0; i < labels.length; i += 1) {
    const x = i % COLUMNS;
    const isObject = x >= from && x < to;
    labels[i] = isObject ? 1 : 0;
    pixels.fill(isObject ? 255 : 10 * x, 4 * i, 4 * i + 3);
  }
  return { pixels, labels };
}

const row = ({ pixels }: Labelled): number[] => Array.from({ length: COLUMNS }, (_, x) => pixels[4 * (COLUMNS * 5 + x)]!);
const EMPTY = Array.from({ length: COLUMNS }, (_, x) => 10 * x);

it('shows what other images have behind the object', () => {
  const first = image(4, 8);
  clearPlace([first, image(14, 18)], COLUMNS);
  expect(row(first)).toEqual(EMPTY);
});

it('fills from the edges what no image shows', () => {
  const first = image(8, 10);
  clearPlace([first, image(9, 12)], COLUMNS);
  const filled = row(first);
  expect(Math.max(...filled.slice(5, 13))).toBeLessThanOrEqual(130);
  expect(filled.slice(0, 5)).toEqual(EMPTY.slice(0, 5));
});

it('leaves images without masks, and those that are all object, as they are', () => {
  const plain = { ...image(4, 8), labels: null };
  clearPlace([plain, image(14, 18)], COLUMNS);
  expect(row(plain)[5]).toBe(255);
  const all = image(0, COLUMNS);
  clearPlace([all], COLUMNS);
  expect(row(all)[5]).toBe(255);
});
