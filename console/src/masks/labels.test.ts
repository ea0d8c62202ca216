import { describe, expect, it } from 'vitest';
import { camera } from '../playback/testing';
import { Masks, readLabels } from './labels';

/** Run lengths of labels as a playback has them. */
function runs(...pairs: (readonly [length: number, label: number])[]): number[] {
  return pairs.flatMap(([length, label]) => {
    const bytes: number[] = [];
    let value = 4 * length + label;
    for (; value > 127; value = Math.floor(value / 128)) bytes.push((value % 128) + 128);
    return [...bytes, value];
  });
}

describe('labels', () => {
  it('are those of their runs, of any length', () => {
    const labels = readLabels(Uint8Array.from(runs([3, 0], [2, 1], [40, 2], [1, 1])), 50);
    expect([...labels]).toEqual([0, 0, 0, 1, 1, ...Array.from({ length: 40 }, () => 2), 1, 0, 0, 0, 0]);
    const large = readLabels(Uint8Array.from(runs([90_000, 0], [70_000, 1])), 160_000);
    expect([large[89_999], large[90_000], large[159_999]]).toEqual([0, 1, 1]);
  });

  it('beyond the image are refused', () => {
    expect(() => readLabels(Uint8Array.from(runs([3, 1], [2, 0])), 4)).toThrow('larger');
    expect(() => readLabels(Uint8Array.from([255, 255, 255, 255, 255, 255, 255, 255, 255, 127]), 4)).toThrow('larger');
  });
});

describe('masks', () => {
  const file = [...runs([4, 1]), ...runs([2, 0], [2, 2]), ...runs([4, 2])];
  const head = camera({
    images: { size: [2, 2], every: 3, lengths: [9, 9, 0, 9], bytes: [0, 27] },
    masks: { lengths: [1, 2, 0, 1], bytes: [100, file.length] },
  });
  const read = ([first, length]: readonly [number, number]): Promise<Uint8Array<ArrayBuffer>> =>
    Promise.resolve(Uint8Array.from(file).slice(first - 100, first - 100 + length));

  it('are those of the images of their frames', async () => {
    const masks = new Masks(head, read);
    expect(masks.isThere).toBe(true);
    expect(masks.at(4)).toBeUndefined();
    await masks.load(4);
    expect([...masks.at(0)!]).toEqual([1, 1, 1, 1]);
    expect([...masks.at(5)!]).toEqual([0, 0, 2, 2]);
    expect(masks.at(6)).toBeNull();
    expect([...masks.at(50)!]).toEqual([2, 2, 2, 2]);
  });

  it('are not there without any', async () => {
    const masks = new Masks(camera(), read);
    await masks.load(2);
    expect([masks.isThere, masks.at(2)]).toEqual([false, null]);
  });
});
