import { h } from '../../ui/dom';
import { BEHIND, type CameraSource } from './source';

/** A button with the image of a camera in the frame that is shown. */
export class Thumbnail {
  readonly element: HTMLButtonElement;
  readonly #canvas = h('canvas');
  #isLoading = false;
  #frame = 0;

  /** `index` is the camera's number, from 0. */
  constructor(private readonly source: CameraSource, index: number, chosen: () => void) {
    const { name, size: [width, height] } = source.head;
    this.#canvas.style.aspectRatio = `${width} / ${height}`;
    const key = index < 9 ? `, key ${index + 1}` : '';
    const label = `Camera ${name || index}`;
    this.element = h('button', {
      type: 'button', class: 'playback-thumbnail', 'aria-pressed': 'false', onclick: chosen,
      title: label + key, 'aria-label': label,
    }, this.#canvas, h('span', {}, name || String(index)));
  }

  /** Shows whether this is the camera that is shown large. */
  press(isChosen: boolean): void {
    this.element.setAttribute('aria-pressed', String(isChosen));
  }

  /** Draws a frame, once it is loaded; the one before stays until then. */
  draw(frame: number): void {
    this.#frame = frame;
    const { images } = this.source;
    const image = images.at(frame);
    if (image !== undefined) this.#paint(image);
    // One request at a time: what is not drawn in time is left out while things are played.
    if (this.#isLoading) return;
    this.#isLoading = true;
    images.load(frame).catch(() => undefined).finally(() => {
      this.#isLoading = false;
      const here = images.at(this.#frame);
      const isLater = this.#frame !== frame;
      if (here === undefined && isLater) this.draw(this.#frame);
      else if (here !== undefined && (image === undefined || isLater)) this.#paint(here);
    });
  }

  #paint(image: ImageBitmap | null): void {
    const context = this.#canvas.getContext('2d');
    if (context === null) return;
    const [width, height] = this.source.head.size;
    const wide = Math.max(Math.round(this.#canvas.clientWidth * devicePixelRatio), 1);
    const size = [wide, Math.max(Math.round((wide * height) / width), 1)] as const;
    if (this.#canvas.width !== size[0]) this.#canvas.width = size[0];
    if (this.#canvas.height !== size[1]) this.#canvas.height = size[1];
    if (image === null) {
      context.fillStyle = BEHIND;
      context.fillRect(0, 0, ...size);
    } else context.drawImage(image, 0, 0, ...size);
  }
}
