import type { Blocks } from '../playback/file/blocks';
import type { CameraHead } from '../playback/file/head';
import type { Read } from '../playback/file/motion';
import { blocksOf } from '../playback/file/pieces';

/** Labels of pixels, by their numbers in a playback. */
export const OBJECT = 1;
export const HAND = 2;

/** Images whose masks one request is for. */
const TOGETHER = 16;
/** Blocks of masks that are kept: of images of 424 x 240 pixels they take 20 MB. */
const KEPT = 12;

/**
 * Labels of the pixels of an image, row by row, from the run lengths of a playback: each run is a
 * number `length * 4 + label` in unsigned LEB128. What the runs do not reach has no label; throws if
 * they reach further.
 */
export function readLabels(runs: Uint8Array, pixels: number): Uint8Array {
  const labels = new Uint8Array(pixels);
  let at = 0;
  let value = 0;
  let factor = 1;
  for (const byte of runs) {
    value += (byte & 127) * factor;
    factor *= 128;
    if (byte > 127) continue;
    const end = at + Math.floor(value / 4);
    if (end > pixels) throw new Error('the masks of an image are larger than it');
    labels.fill(value % 4, at, end);
    at = end;
    value = 0;
    factor = 1;
  }
  return labels;
}

/** Masks of a camera, fetched on demand. */
export class Masks {
  readonly #count: number;
  readonly #blocks: Blocks<(Uint8Array | null)[]>;

  constructor(
    private readonly camera: CameraHead,
    read: Read,
  ) {
    const pieces = camera.masks ?? { lengths: [], bytes: [0, 0] as const };
    this.#count = pieces.lengths.length;
    const [columns, rows] = camera.images.size;
    this.#blocks = blocksOf<Uint8Array>(pieces, read, [TOGETHER, KEPT], (runs) => readLabels(runs, columns * rows));
  }

  /** True if the camera has masks. */
  get isThere(): boolean {
    return this.#count > 0;
  }

  /** Labels of the image of a frame: undefined while they are not here, null if there are none. */
  at(frame: number): Uint8Array | null | undefined {
    const index = this.#indexOf(frame);
    if (index === null) return null;
    const block = this.#blocks.peek(index);
    return block === undefined ? undefined : (block[index % TOGETHER] ?? null);
  }

  /** Loads the masks of a frame. */
  async load(frame: number): Promise<void> {
    const index = this.#indexOf(frame);
    if (index !== null) await this.#blocks.get(index);
  }

  #indexOf(frame: number): number | null {
    const index = Math.min(Math.floor(frame / this.camera.images.every), this.#count - 1);
    return index >= 0 ? index : null;
  }
}
