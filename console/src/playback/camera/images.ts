import type { Blocks } from '../file/blocks';
import type { CameraHead } from '../file/head';
import type { Read } from '../file/motion';
import { blocksOf } from '../file/pieces';

/** Images that one request is for, unless it is said otherwise. */
const TOGETHER = 8;
/** Blocks of images that are kept decoded: 96 images of 424 x 240 pixels take 39 MB. */
const KEPT = 12;

/** Images of a camera, fetched on demand. */
export class Images {
  readonly #blocks: Blocks<(ImageBitmap | null)[]>;

  constructor(
    private readonly camera: CameraHead,
    read: Read,
    decode: (file: Blob) => Promise<ImageBitmap> = createImageBitmap,
    private readonly together = TOGETHER,
    /** Blocks that are kept decoded. */
    kept = KEPT,
  ) {
    this.#blocks = blocksOf<ImageBitmap>(
      camera.images,
      read,
      [together, kept],
      // One that does not decode is shown as one that was not recorded.
      (file) => decode(new Blob([file], { type: 'image/jpeg' })).catch(() => null),
      (images) => images.forEach((image) => image?.close()),
    );
  }

  /** Number of the image shown in a frame, its own or the last one before it; null without any. */
  indexAt(frame: number): number | null {
    const { every, lengths } = this.camera.images;
    const index = Math.min(Math.floor(frame / every), lengths.length - 1);
    return index >= 0 && (lengths[index] ?? 0) > 0 ? index : null;
  }

  /** The image of a frame: undefined while it is not here, null if none was recorded. */
  at(frame: number): ImageBitmap | null | undefined {
    const index = this.indexAt(frame);
    if (index === null) return null;
    const block = this.#blocks.peek(index);
    return block === undefined ? undefined : (block[index % this.together] ?? null);
  }

  /** Loads the image of a frame, and begins to load those after it. */
  async load(frame: number): Promise<void> {
    const index = this.indexAt(frame);
    if (index === null) return;
    await this.#blocks.get(index);
    const next = (Math.floor(index / this.together) + 1) * this.together;
    // One that is asked for by itself is of a strip, whose next one is another.
    if (this.together > 1 && next < this.camera.images.lengths.length) void this.#blocks.get(next).catch(() => undefined);
  }

  dispose(): void {
    this.#blocks.clear();
  }
}
