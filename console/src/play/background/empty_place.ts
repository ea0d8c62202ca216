/** An image as bytes, red, green, blue, opacity of each pixel, row by row, and the labels of its pixels. */
export interface Labelled {
  readonly pixels: Uint8ClampedArray;
  /** 0 for what is neither object nor hand; null if the image has no masks. */
  readonly labels: Uint8Array | null;
}

/** Pixels around a mask that count as covered: its edge is soft in the image, and a shadow may lie there. */
const MARGIN = 3;

/**
 * The first image without the object and without hands: where they are, other images of the same camera have what is
 * behind them, and what none of them shows is filled from its edges. Writes into the first image.
 */
export function clearPlace(images: readonly Labelled[], columns: number): void {
  const [first, ...others] = images;
  if (first === undefined || first.labels === null) return;
  const covered = grown(first.labels, columns);
  const clear = others.flatMap(({ pixels, labels }) => (labels === null ? [] : [{ pixels, covered: grown(labels, columns) }]));
  for (let i = 0; i < covered.length; i += 1) {
    if (covered[i] === 0) continue;
    const seen = clear.filter((image) => image.covered[i] === 0);
    if (seen.length === 0) continue;
    for (let c = 0; c < 3; c += 1) {
      // The middle value, as a mask may have missed a part of a hand.
      const values = seen.map(({ pixels }) => pixels[4 * i + c]!).sort((a, b) => a - b);
      first.pixels[4 * i + c] = values[values.length >> 1]!;
    }
    covered[i] = 0;
  }
  fill(first.pixels, covered, columns);
}

/** 1 for pixels that are within the margin of a label. */
function grown(labels: Uint8Array, columns: number): Uint8Array {
  const rows = labels.length / columns;
  const out = new Uint8Array(labels.length);
  for (let y = 0; y < rows; y += 1) {
    for (let x = 0; x < columns; x += 1) {
      if (labels[columns * y + x] === 0) continue;
      for (let v = Math.max(y - MARGIN, 0); v <= Math.min(y + MARGIN, rows - 1); v += 1) {
        out.fill(1, columns * v + Math.max(x - MARGIN, 0), columns * v + Math.min(x + MARGIN, columns - 1) + 1);
      }
    }
  }
  return out;
}

/** Fills covered pixels ring by ring with means of their known neighbours. */
function fill(pixels: Uint8ClampedArray, covered: Uint8Array, columns: number): void {
  let left = Array.from(covered.keys()).filter((i) => covered[i] !== 0);
  while (left.length > 0) {
    const found = left.flatMap((i) => {
      const x = i % columns;
      const near = [x > 0 ? i - 1 : -1, x + 1 < columns ? i + 1 : -1, i - columns, i + columns]
        .filter((j) => j >= 0 && j < covered.length && covered[j] === 0);
      return near.length === 0 ? [] : [{ i, near }];
    });
    if (found.length === 0) return;
    for (const { i, near } of found) {
      for (let c = 0; c < 3; c += 1) {
        pixels[4 * i + c] = near.reduce((sum, j) => sum + pixels[4 * j + c]!, 0) / near.length;
      }
    }
    for (const { i } of found) covered[i] = 0;
    left = left.filter((i) => covered[i] !== 0);
  }
}
