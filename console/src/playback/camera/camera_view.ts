import { h } from '../../ui/dom';
import { BEHIND, type CameraSource } from './source';

/** Points that are drawn into an image. */
export interface Dots {
  /** [m], shape [M, 3]; not a number for those that are left out. */
  readonly points: Float32Array;
  /** Colour of all of them, or red, green and blue as bytes of each, shape [M, 3]. */
  readonly colour: string | Uint8Array;
  /** Radius [pixels of the page]. */
  readonly radius: number;
  /** Pairs of points that lines connect, shape [L, 2]. */
  readonly lines?: Uint32Array;
}

/** Images of one camera after the other, with points drawn into them. */
export class CameraView {
  readonly element: HTMLElement;
  readonly canvas = h('canvas', { role: 'img' });
  readonly #note = h('figcaption');
  readonly #resize: ResizeObserver;

  /** `changed` is called when the view has to be redrawn. */
  constructor(
    private source: CameraSource,
    changed: () => void,
  ) {
    this.element = h('figure', { class: 'playback-camera' }, this.canvas, this.#note);
    this.#resize = new ResizeObserver(changed);
    this.#resize.observe(this.canvas);
    this.show(source);
  }

  /** Shows another camera from now on. */
  show(source: CameraSource): void {
    this.source = source;
    const { name, size: [width, height] } = source.head;
    this.canvas.setAttribute('aria-label', `Image of camera ${name}, with points drawn into it`);
    this.canvas.style.aspectRatio = `${width} / ${height}`;
  }

  /** Draws a frame. */
  draw(frame: number, layers: readonly Dots[]): void {
    const { head, images, projection } = this.source;
    const context = this.canvas.getContext('2d');
    const image = images.at(frame);
    if (context === null || image === undefined || projection === null) return;
    const ratio = devicePixelRatio;
    const [width, height] = head.size;
    const wide = Math.max(Math.round(this.canvas.clientWidth * ratio), 1);
    const size = [wide, Math.max(Math.round((wide * height) / width), 1)] as const;
    if (this.canvas.width !== size[0]) this.canvas.width = size[0];
    if (this.canvas.height !== size[1]) this.canvas.height = size[1];
    context.fillStyle = BEHIND;
    context.fillRect(0, 0, ...size);
    if (image !== null) context.drawImage(image, 0, 0, ...size);
    const index = images.indexAt(frame);
    const shown = index === null ? frame : index * head.images.every;
    this.#say(frame, image === null ? null : shown);
    const scale = wide / width;
    // Points of one frame lie wrongly on the image of another.
    if (image !== null && shown !== frame) context.globalAlpha = 0.6;
    for (const dots of layers) {
      drawDots(context, projection.pixels(dots.points, index ?? 0), dots, { scale, ratio });
    }
    context.globalAlpha = 1;
  }

  dispose(): void {
    this.#resize.disconnect();
  }

  #say(frame: number, shown: number | null): void {
    const { name, images } = this.source.head;
    const said = ((): string => {
      if (images.lengths.length === 0) return ': its images were left out for lack of space.';
      if (shown === null) return ': no image was recorded here.';
      return shown === frame ? '' : `: the image is of frame ${shown}, the points are of ${frame}.`;
    })();
    const text = `Camera ${name}${said}`;
    if (this.#note.textContent !== text) this.#note.textContent = text;
  }
}

/** Draws points, whose pixels are those of the recorded image, and the lines between them. */
function drawDots(
  context: CanvasRenderingContext2D,
  pixels: Float32Array,
  { colour, radius, lines }: Dots,
  { scale, ratio }: { scale: number; ratio: number },
): void {
  // The centre of the first pixel is half a pixel from the edge.
  const x = (m: number): number => (pixels[2 * m]! + 0.5) * scale;
  const y = (m: number): number => (pixels[2 * m + 1]! + 0.5) * scale;
  if (lines !== undefined && typeof colour === 'string') {
    context.beginPath();
    for (let l = 0; l + 1 < lines.length; l += 2) {
      const [a, b] = [lines[l]!, lines[l + 1]!];
      if (Number.isNaN(x(a)) || Number.isNaN(x(b))) continue;
      context.moveTo(x(a), y(a));
      context.lineTo(x(b), y(b));
    }
    context.strokeStyle = colour;
    context.lineWidth = 0.75 * ratio;
    // What lies behind the springs stays to be seen.
    const alpha = context.globalAlpha;
    context.globalAlpha = 0.3 * alpha;
    context.stroke();
    context.globalAlpha = alpha;
  }
  const side = 2 * radius * ratio;
  if (typeof colour === 'string') context.fillStyle = colour;
  for (let m = 0; 2 * m < pixels.length; m += 1) {
    if (Number.isNaN(x(m))) continue;
    if (typeof colour !== 'string') {
      context.fillStyle = `rgb(${colour[3 * m]!} ${colour[3 * m + 1]!} ${colour[3 * m + 2]!})`;
    }
    context.fillRect(x(m) - side / 2, y(m) - side / 2, side, side);
  }
}
