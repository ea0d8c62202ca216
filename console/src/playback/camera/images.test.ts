import { describe, expect, it } from 'vitest';
import { Images } from './images';
import { camera } from '../testing';

/** Images whose files have their own numbers as content, and how many of them are open. */
function images(lengths: number[], every = 1): { images: Images; open: Set<number>; reads: number[] } {
  const data = new Uint8Array(lengths.flatMap((length, k) => Array.from({ length }, () => k)));
  const open = new Set<number>();
  const reads: number[] = [];
  const head = camera({ images: { size: [1, 1], every, lengths, bytes: [7, data.length] } });
  const read = ([first, length]: readonly [number, number]): Promise<Uint8Array<ArrayBuffer>> => {
    reads.push(length);
    return Promise.resolve(data.slice(first - 7, first - 7 + length));
  };
  const decode = async (file: Blob): Promise<ImageBitmap> => {
    const number = new Uint8Array(await file.arrayBuffer())[0]!;
    if (number === 3) throw new Error('damaged');
    open.add(number);
    return { width: number, close: () => open.delete(number) } as unknown as ImageBitmap;
  };
  return { images: new Images(head, read, decode), open, reads };
}

describe('images', () => {
  it('are those of their frames', async () => {
    const { images: i } = images([2, 3, 0, 4, 5, 1, 1, 1, 1, 1]);
    expect(i.at(4)).toBeUndefined();
    await i.load(4);
    expect([0, 1, 4, 7].map((frame) => i.at(frame)?.width)).toEqual([0, 1, 4, 7]);
    // Not recorded, and damaged.
    expect([i.at(2), i.at(3)]).toEqual([null, null]);
    await i.load(9);
    expect(i.at(9)?.width).toBe(9);
    expect(i.at(50)?.width).toBe(9);
  });

  it('of every fourth frame stay until the next', async () => {
    const { images: i } = images([1, 1, 1], 4);
    await i.load(7);
    expect([0, 3, 4, 7, 8, 30].map((frame) => i.at(frame)?.width)).toEqual([0, 0, 1, 1, 2, 2]);
    expect(i.indexAt(7)).toBe(1);
  });

  it('are kept within a bound, and closed', async () => {
    const { images: i, open, reads } = images(Array.from({ length: 200 }, () => 1));
    for (let frame = 0; frame < 200; frame += 8) await i.load(frame);
    await new Promise((resolve) => setTimeout(resolve, 5));
    expect(open.size).toBeLessThanOrEqual(96);
    expect(i.at(0)).toBeUndefined();
    expect(reads).toHaveLength(25);
    i.dispose();
    expect(open.size).toBe(0);
  });

  it('of a recording without any are none', async () => {
    const { images: i } = images([]);
    await i.load(3);
    expect(i.at(3)).toBeNull();
  });
});
