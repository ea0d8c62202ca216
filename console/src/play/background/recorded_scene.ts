import type { Api } from '../../api/client';
import { readLabels } from '../../masks/labels';
import { PlaybackFile } from '../../playback/file/file';
import type { CameraHead, SequenceHead } from '../../playback/file/head';
import { Motion } from '../../playback/file/motion';
import type { Pieces } from '../../playback/file/pieces';
import type { Photograph } from '../../view3d/layers/photograph';
import { clearPlace, type Labelled } from './empty_place';

/** Images of a camera out of which the object is taken. */
const IMAGES = 9;

/** The scene in which the object of a twin was recorded, from the playback of its capture. */
export class RecordedScene {
  private constructor(
    private readonly file: PlaybackFile,
    private readonly sequence: SequenceHead,
  ) {}

  /** Opens the playback of a capture; null if it has no sequence. */
  static async open(api: Api, capture: string, signal: AbortSignal): Promise<RecordedScene | null> {
    const file = await PlaybackFile.open(api, capture, signal);
    const [sequence] = file.head.sequences;
    return sequence === undefined ? null : new RecordedScene(file, sequence);
  }

  /** Calibrated cameras that have an image of the start of the motion, with their names. */
  get cameras(): readonly (readonly [index: number, name: string])[] {
    return this.sequence.cameras.flatMap((camera, index) => {
      const hasImage = (camera.images.lengths[this.#first(camera)] ?? 0) > 0;
      return hasImage && camera.poses[1] > 0 ? [[index, camera.name || String(index + 1)] as const] : [];
    });
  }

  /** True if points were observed. */
  get hasPoints(): boolean {
    return this.sequence.motion.point_count > 0;
  }

  /** Points at the start of the motion [m], shape [M, 3], and their colours, shape [M, 3], if they have any. */
  async points(): Promise<{ points: Float32Array; colours: Uint8Array | null }> {
    const { motion, frame_count, start_frame } = this.sequence;
    const read = this.file.read.bind(this.file);
    const motions = new Motion(motion, frame_count, read);
    const [colours] = await Promise.all([motion.colors === null ? null : read(motion.colors), motions.load(start_frame)]);
    const { points } = motions.frame(start_frame)!;
    const known = Array.from({ length: points.length / 3 }, (_, i) => i).filter((i) => !Number.isNaN(points[3 * i]!));
    const of = (values: ArrayLike<number>): number[] => known.flatMap((i) => [values[3 * i]!, values[3 * i + 1]!, values[3 * i + 2]!]);
    return { points: Float32Array.from(of(points)), colours: colours === null ? null : Uint8Array.from(of(colours)) };
  }

  /** What a camera saw at the start of the motion, without object and hands if there are masks of them. */
  async photograph(index: number): Promise<Photograph> {
    const camera = this.sequence.cameras[index];
    if (camera === undefined) throw new Error('the capture has no such camera');
    const poses = new Float32Array((await this.file.read(camera.poses)).buffer);
    const first = this.#first(camera);
    const count = camera.images.lengths.length;
    // Only a camera that stands sees the same place in its other images.
    const others = poses.length > 12 || !camera.masks ? [] : Array.from({ length: IMAGES - 1 }, (_, i) => {
      return Math.floor(((i + 1) * count) / IMAGES);
    });
    const images = (await Promise.all([first, ...others].map((k) => this.#image(camera, k)))).filter((image) => image !== null);
    const [own] = images;
    if (own === undefined) throw new Error('the image of this camera cannot be read');
    const [columns, rows] = camera.images.size;
    clearPlace(images, columns);
    const { size, intrinsics, distortion } = camera;
    const pose = poses.subarray(...(poses.length > 12 ? [12 * first, 12 * first + 12] : [0, 12]));
    return { size, intrinsics, distortion, pose, image: new ImageData(new Uint8ClampedArray(own.pixels), columns, rows) };
  }

  /** Number of the image at the start of the motion. */
  #first({ images }: CameraHead): number {
    return Math.min(Math.floor(this.sequence.start_frame / images.every), Math.max(images.lengths.length - 1, 0));
  }

  /** An image with its labels; null if it is missing or damaged. */
  async #image({ images, masks }: CameraHead, k: number): Promise<Labelled | null> {
    const [columns, rows] = images.size;
    const [bytes, runs] = await Promise.all([this.#piece(images, k), masks ? this.#piece(masks, k) : null]);
    if (bytes.length === 0) return null;
    try {
      const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/jpeg' }));
      const context = new OffscreenCanvas(columns, rows).getContext('2d')!;
      context.drawImage(bitmap, 0, 0, columns, rows);
      bitmap.close();
      const labels = runs === null || runs.length === 0 ? null : readLabels(runs, columns * rows);
      return { pixels: context.getImageData(0, 0, columns, rows).data, labels };
    } catch {
      return null;
    }
  }

  #piece({ lengths, bytes: [first] }: Pieces, k: number): Promise<Uint8Array<ArrayBuffer>> {
    const before = lengths.slice(0, k).reduce((sum, length) => sum + length, 0);
    return this.file.read([first + before, lengths[k] ?? 0]);
  }
}
