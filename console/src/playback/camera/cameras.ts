import { h } from '../../ui/dom';
import type { CameraHead } from '../file/head';
import type { Read } from '../file/motion';
import { CameraView, type Dots } from './camera_view';
import { CameraSource } from './source';
import { Thumbnail } from './thumbnail';

/** Blocks of decoded images of all cameras together, and least and most of one. */
const KEPT = { all: 24, least: 3, most: 12 };

/** All cameras of a sequence, at least one: one of them large, and below it a strip with the images of all. */
export class Cameras {
  readonly element: HTMLElement;
  readonly #sources: readonly CameraSource[];
  readonly #thumbnails: readonly Thumbnail[];
  readonly #view: CameraView;
  #chosen: number;
  /** Called when a frame has to be drawn again. */
  changed: () => void = () => undefined;

  constructor(heads: readonly CameraHead[], read: Read, chosen: number) {
    const kept = Math.min(Math.max(Math.ceil(KEPT.all / heads.length), KEPT.least), KEPT.most);
    this.#sources = heads.map((head) => new CameraSource(head, read, kept));
    this.#chosen = chosen in heads ? chosen : 0;
    this.#view = new CameraView(this.#source, () => this.changed());
    const thumbnails = this.#sources.length < 2 ? [] : this.#sources;
    this.#thumbnails = thumbnails.map((source, index) => new Thumbnail(source, index, () => this.choose(index)));
    const strip = h('div', { class: 'playback-thumbnails', role: 'group', 'aria-label': 'Cameras' },
      ...this.#thumbnails.map(({ element }) => element));
    this.element = h('div', { class: 'playback-cameras' }, this.#view.element, this.#thumbnails.length === 0 ? null : strip);
    this.#press();
  }

  /** Number of the camera that is shown large, from 0. */
  get chosen(): number {
    return this.#chosen;
  }

  /** The large image, with the points in it. */
  get canvas(): HTMLCanvasElement {
    return this.#view.canvas;
  }

  /** Name of the camera that is shown large. */
  get name(): string {
    return this.#source.head.name || String(this.#chosen);
  }

  /** Shows a camera large, if there is one of this number. */
  choose(index: number): void {
    if (index === this.#chosen || this.#sources[index] === undefined) return;
    this.#chosen = index;
    this.#view.show(this.#source);
    this.#press();
    this.changed();
  }

  /** True if the large image of a frame can be drawn. */
  has(frame: number): boolean {
    return this.#source.has(frame);
  }

  /** Loads the large image of a frame. */
  async load(frame: number): Promise<void> {
    await this.#source.load(frame);
  }

  /** Draws a frame: points into the large image, and the images of the others that are loaded. */
  draw(frame: number, layers: readonly Dots[]): void {
    this.#view.draw(frame, layers);
    this.#thumbnails.forEach((thumbnail) => thumbnail.draw(frame));
  }

  dispose(): void {
    this.#view.dispose();
    this.#sources.forEach((source) => source.dispose());
  }

  get #source(): CameraSource {
    return this.#sources[this.#chosen]!;
  }

  /** Shows which camera is large; the column of images gets the shape of its images. */
  #press(): void {
    const [width, height] = this.#source.head.size;
    this.element.style.setProperty('--aspect', String(width / height));
    this.#thumbnails.forEach((thumbnail, index) => thumbnail.press(index === this.#chosen));
  }
}
