import { Blocks } from './blocks';
import type { Range } from './head';
import type { Read } from './motion';

/** Pieces of a playback's data, one for each image of a camera, in order; an image without a piece has 0 bytes. */
export interface Pieces {
  readonly lengths: readonly number[];
  readonly bytes: Range;
}

/** Pieces in blocks of `size` neighbours, of which `most` are kept; null for those without bytes. */
export function blocksOf<T>(
  { lengths, bytes }: Pieces,
  read: Read,
  [size, most]: readonly [size: number, most: number],
  decode: (piece: Uint8Array<ArrayBuffer>) => T | null | Promise<T | null>,
  release?: (pieces: (T | null)[]) => void,
): Blocks<(T | null)[]> {
  let at = 0;
  const starts = [0, ...lengths.map((length) => (at += length))];
  const load = async (block: number): Promise<(T | null)[]> => {
    const first = block * size;
    const end = Math.min(first + size, lengths.length);
    const from = starts[first]!;
    const data = await read([bytes[0] + from, starts[end]! - from]);
    return Promise.all(
      lengths.slice(first, end).map(async (length, i) => {
        const start = starts[first + i]! - from;
        return length === 0 ? null : decode(data.subarray(start, start + length));
      }),
    );
  };
  return new Blocks(size, most, load, release);
}
