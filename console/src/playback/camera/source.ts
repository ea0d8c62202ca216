import type { CameraHead } from '../file/head';
import type { Read } from '../file/motion';
import { Images } from './images';
import { Projection } from './projection';

/** Colour behind images, and in place of missing ones. */
export const BEHIND = '#14181d';

/** What a camera has for its views: images and the projection into them, loaded when they are needed. */
export class CameraSource {
  readonly images: Images;
  readonly #read: Promise<unknown>;
  #projection: Projection | null = null;

  /** `kept` is the number of blocks of images that stay decoded. */
  constructor(readonly head: CameraHead, read: Read, kept: number) {
    this.images = new Images(head, read, undefined, undefined, kept);
    this.#read = read(head.poses).then((bytes) => {
      this.#projection = new Projection(head, new Float32Array(bytes.buffer));
    });
    // The error goes to the caller that loads a frame.
    this.#read.catch(() => undefined);
  }

  /** The projection, or null while it is not here. */
  get projection(): Projection | null {
    return this.#projection;
  }

  /** Loads what a frame needs, and begins to load what follows. */
  async load(frame: number): Promise<void> {
    await Promise.all([this.images.load(frame), this.#read]);
  }

  /** True if a frame can be drawn. */
  has(frame: number): boolean {
    return this.#projection !== null && this.images.at(frame) !== undefined;
  }

  dispose(): void {
    this.images.dispose();
  }
}
