import { crc32, deflateSync } from 'node:zlib';
import { distance, type Colour, type Picture } from './pixels';

/** Colours of an animation; one more index stands for what stays. */
const COLOURS = 255;
/** Distance between the first colours of a palette. */
const APART = 32;

/**
 * An animated PNG of pictures of one size: each is shown for `delayMs`, the last for `lastMs`, then it begins again.
 * It has a palette, and of each picture the rectangle that has changed.
 */
export function animation(pictures: readonly Picture[], delayMs: number, lastMs: number): Buffer {
  const { width, height } = pictures[0]!;
  const palette = paletteOf(pictures);
  const indexOf = nearestIn(palette);
  const chunks = [
    chunk('IHDR', bytes([4, width], [4, height], [1, 8], [1, 3], [1, 0], [1, 0], [1, 0])),
    chunk('acTL', bytes([4, pictures.length], [4, 0])),
    chunk('PLTE', Buffer.from([0, 0, 0, ...palette.flat()])),
    chunk('tRNS', Buffer.from([0])),
  ];
  let sequence = 0;
  let before: Uint8Array = new Uint8Array(width * height);
  for (const picture of pictures) {
    const isFirst = sequence === 0;
    const now = Uint8Array.from({ length: width * height }, (_, i) => indexOf(picture.data, 4 * i));
    const area = changedArea(before, now, width);
    const delay = picture === pictures.at(-1) ? lastMs : delayMs;
    // The frame lies over what was there before: index 0 is transparent.
    const place = [area.width, area.height, area.x, area.y].map((n) => [4, n] as const);
    chunks.push(chunk('fcTL', bytes([4, sequence++], ...place, [2, delay], [2, 1000], [1, 0], [1, 1])));
    const data = deflateSync(rowsOf(before, now, width, area), { level: 9 });
    chunks.push(isFirst ? chunk('IDAT', data) : chunk('fdAT', Buffer.concat([bytes([4, sequence++]), data])));
    before = now;
  }
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  return Buffer.concat([signature, ...chunks, chunk('IEND', Buffer.alloc(0))]);
}

/**
 * Colours that stand for all others, each the mean of those that agree in five bits of each channel: some at a
 * distance from each other, so that none is far from a rare one, then the most frequent.
 */
function paletteOf(pictures: readonly Picture[]): Colour[] {
  const sums = new Map<number, [red: number, green: number, blue: number, count: number]>();
  for (const { data } of pictures) {
    for (let i = 0; i < data.length; i += 4) {
      const sum = sums.get(coarse(data, i)) ?? [0, 0, 0, 0];
      sums.set(coarse(data, i), [sum[0] + data[i]!, sum[1] + data[i + 1]!, sum[2] + data[i + 2]!, sum[3] + 1]);
    }
  }
  const frequent = [...sums.values()].sort((a, b) => b[3] - a[3]);
  const colours = frequent.map(([red, green, blue, count]): Colour => [red / count, green / count, blue / count]);
  const apart: Colour[] = [];
  for (const colour of colours) if (apart.every((other) => distance(colour, other) > APART)) apart.push(colour);
  return [...new Set([...apart, ...colours])].slice(0, COLOURS);
}

/** A function that gives the index of the colour nearest to a pixel, from 1 on. */
function nearestIn(palette: readonly Colour[]): (data: Uint8ClampedArray, i: number) => number {
  const known = new Map<number, number>();
  return (data, i) => {
    const key = coarse(data, i);
    let index = known.get(key);
    if (index === undefined) {
      const apart = palette.map((colour) => distance(colour, [data[i]!, data[i + 1]!, data[i + 2]!]));
      index = 1 + apart.indexOf(Math.min(...apart));
      known.set(key, index);
    }
    return index;
  };
}

function coarse(data: Uint8ClampedArray, i: number): number {
  return ((data[i]! >> 3) << 10) | ((data[i + 1]! >> 3) << 5) | (data[i + 2]! >> 3);
}

interface Area {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** The rectangle that has all pixels that differ, at least one pixel. */
function changedArea(before: Uint8Array, now: Uint8Array, width: number): Area {
  let [left, right, top, bottom] = [Infinity, -1, Infinity, -1];
  now.forEach((index, i) => {
    if (index === before[i]) return;
    const [x, y] = [i % width, Math.floor(i / width)];
    [left, right, top, bottom] = [Math.min(left, x), Math.max(right, x), Math.min(top, y), Math.max(bottom, y)];
  });
  return right < 0 ? { x: 0, y: 0, width: 1, height: 1 } : { x: left, y: top, width: right - left + 1, height: bottom - top + 1 };
}

/** Rows of an area, each after its filter, none: indices, 0 where nothing has changed. */
function rowsOf(before: Uint8Array, now: Uint8Array, width: number, { x, y, ...area }: Area): Uint8Array {
  const rows = new Uint8Array((area.width + 1) * area.height);
  for (let row = 0; row < area.height; row += 1) {
    for (let column = 0; column < area.width; column += 1) {
      const i = (y + row) * width + x + column;
      rows[row * (area.width + 1) + 1 + column] = now[i] === before[i] ? 0 : now[i]!;
    }
  }
  return rows;
}

/** Unsigned numbers, each of one, two or four bytes, the highest first. */
function bytes(...parts: (readonly [size: number, value: number])[]): Buffer {
  return Buffer.concat(parts.map(([size, value]) => {
    const part = Buffer.alloc(size);
    part.writeUIntBE(value, 0, size);
    return part;
  }));
}

function chunk(type: string, data: Buffer): Buffer {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  return Buffer.concat([bytes([4, data.length]), body, bytes([4, crc32(body)])]);
}
