/** A colour, red, green and blue in 0..=1. */
export type Colour = readonly [number, number, number];

/** Colours of values, in steps of equal size from the least to the greatest. */
export interface ColourMap {
  readonly name: string;
  /** Colours as hex, from the least value to the greatest. */
  readonly stops: readonly string[];
}

/** From little to much: viridis, which rises in lightness, so that it can be read without seeing colours. */
export const SEQUENTIAL: ColourMap = {
  name: 'dark violet to yellow',
  stops: ['440154', '482878', '3e4a89', '31688e', '26828e', '1f9e89', '35b779', '6ece58', 'b5de2b', 'fde725'],
};

/** From negative over zero to positive: blue, grey, orange, distinct for all kinds of colour vision. */
export const DIVERGING: ColourMap = {
  name: 'blue over grey to orange',
  stops: ['0a58a8', '3b87c8', '7fb0d6', 'a9b1b8', 'e0a878', 'e07b26', 'b34700'],
};

/** Values that the ends of a colour map stand for. */
export interface Range {
  readonly low: number;
  readonly high: number;
}

/** Colour of a share of the way through a map; beyond its ends it is that of the end. */
export function colourAt(map: ColourMap, share: number): Colour {
  const place = Math.min(Math.max(Number.isFinite(share) ? share : 0, 0), 1) * (map.stops.length - 1);
  const index = Math.min(Math.floor(place), map.stops.length - 2);
  const [low, high] = [hex(map.stops[index]!), hex(map.stops[index + 1]!)];
  const part = place - index;
  return [0, 1, 2].map((c) => low[c]! + part * (high[c]! - low[c]!)) as unknown as Colour;
}

/** Share of the way from the least value of a range to its greatest, not held within 0..=1. */
export function shareOf(range: Range, value: number): number {
  return range.high > range.low ? (value - range.low) / (range.high - range.low) : 0.5;
}

/** Range of all but the farthest hundredth of values at each end, so that a few do not take all colours. */
export function rangeOf(values: ArrayLike<number>): Range {
  const sorted = Float32Array.from(values).filter(Number.isFinite).sort();
  if (sorted.length === 0) return { low: 0, high: 1 };
  const at = (share: number): number => sorted[Math.round(share * (sorted.length - 1))]!;
  return { low: at(0.01), high: at(0.99) };
}

/** Bytes of a texture of `count` colours of a map, shape [count, 4]. */
export function texels(map: ColourMap, count: number): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(4 * count);
  for (let i = 0; i < count; i += 1) {
    const colour = colourAt(map, i / (count - 1));
    bytes.set([...colour.map((part) => Math.round(255 * part)), 255], 4 * i);
  }
  return bytes;
}

function hex(text: string): Colour {
  const value = Number.parseInt(text, 16);
  return [((value >> 16) & 255) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}
