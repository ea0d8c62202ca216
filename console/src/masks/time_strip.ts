import { begun, onPressed } from '../playback/canvas';
import { Images } from '../playback/camera/images';
import type { CameraHead } from '../playback/file/head';
import type { Read } from '../playback/file/motion';
import { h } from '../ui/dom';
import { percent } from '../ui/format';
import { LEVELS, levelOf, summary } from './doubt';
import { colourOf, overlayOf } from './drawing';
import type { Masks } from './labels';
import type { Stroke } from './strokes';

/** Heights of the images and of the bar of doubt [pixels of the page]. */
const IMAGES_PX = 44;
const BAR_PX = 22;
/** Doubt that fills the bar. */
const FULL = 0.5;
/** Most images of a strip. */
const MOST_IMAGES = 24;
/** Pause after a change of size before a strip is made anew [ms]. */
const PAUSE_MS = 200;

/** A camera along time: a strip of its images with their masks, and a bar of doubt. A place in it that is pointed at is shown. */
export class TimeStrip {
  readonly element: HTMLElement;
  readonly #strip = h('canvas', { class: 'masks-strip', 'aria-hidden': 'true' });
  readonly #bar = h('canvas', { class: 'masks-bar', role: 'img' });
  readonly #text = h('p', { class: 'hint' });
  readonly #images: Images;
  readonly #resize = new ResizeObserver(() => this.#later());
  /** Images of the strip, as they come. */
  #pictures: (OffscreenCanvas | null)[] = [];
  #strokes: readonly Stroke[] = [];
  #frame = 0;
  #pause = 0;
  #run = 0;

  constructor(
    private readonly camera: CameraHead,
    read: Read,
    private readonly masks: Masks,
    private readonly frameCount: number,
    seek: (frame: number) => void,
  ) {
    this.#images = new Images(camera, read, undefined, 1);
    const place = h('div', { class: 'masks-time' }, this.#strip, this.#bar);
    this.element = h('div', { class: 'masks-line' }, h('p', { class: 'masks-name' }, h('bdi', {}, camera.name)), place, this.#text);
    onPressed(place, (share) => seek(Math.floor(share * frameCount)));
    this.#resize.observe(place);
  }

  /** Marks a frame, and those that have strokes, and says the doubt. */
  show(frame: number, strokes: readonly Stroke[]): void {
    this.#frame = frame;
    this.#strokes = strokes;
    const { doubt } = this.camera;
    const here = levelOf(doubt?.[frame]);
    const now = here === null ? '' : ` Here: ${here.word} (${percent(doubt![frame]!)}).`;
    const whole = doubt ? `Doubt: ${summary(doubt)}.` : this.masks.isThere ? 'These masks have no measure of doubt.' : 'No masks yet.';
    const frames = [...new Set(strokes.map((stroke) => stroke.frame))].sort((a, b) => a - b);
    const marked = frames.length === 0 ? '' : ` Marked in ${frames.length === 1 ? 'frame' : 'frames'} ${frames.join(', ')}.`;
    this.#text.textContent = whole + now + marked;
    this.#bar.setAttribute('aria-label', `Camera ${this.camera.name}. ${whole}${marked}`);
    this.#draw();
  }

  dispose(): void {
    clearTimeout(this.#pause);
    this.#run = -1;
    this.#resize.disconnect();
    this.#images.dispose();
  }

  /** Fetches the images for the present width, unless it has not changed. */
  #later(): void {
    clearTimeout(this.#pause);
    this.#draw();
    this.#pause = window.setTimeout(() => void this.#fill(), this.#pictures.length === 0 ? 0 : PAUSE_MS);
  }

  async #fill(): Promise<void> {
    const [columns, rows] = this.camera.size;
    const each = (IMAGES_PX * columns) / rows;
    const count = Math.min(Math.max(Math.floor(this.#strip.clientWidth / each), 1), MOST_IMAGES, this.frameCount);
    if (count === this.#pictures.length) return;
    const run = (this.#run += 1);
    this.#pictures = Array.from({ length: count }, () => null);
    for (let i = 0; i < count; i += 1) {
      const frame = Math.floor(((i + 0.5) / count) * this.frameCount);
      // One that cannot be fetched stays empty; the image itself says why.
      await Promise.all([this.#images.load(frame), this.masks.load(frame)]).catch(() => undefined);
      if (run !== this.#run) return;
      this.#pictures[i] = this.#pictureOf(frame);
      this.#draw();
    }
  }

  /** The image of a frame with its masks, in the size of its drawing. */
  #pictureOf(frame: number): OffscreenCanvas | null {
    const image = this.#images.at(frame);
    if (image === null || image === undefined) return null;
    const [columns, rows] = this.camera.size;
    const height = Math.round(IMAGES_PX * devicePixelRatio);
    const canvas = new OffscreenCanvas(Math.max(Math.round((height * columns) / rows), 1), height);
    const context = canvas.getContext('2d');
    if (context === null) return null;
    context.drawImage(image, 0, 0, canvas.width, height);
    const labels = this.masks.at(frame);
    const overlay = labels ? overlayOf(labels, this.camera.images.size) : null;
    if (overlay !== null) context.drawImage(overlay, 0, 0, canvas.width, height);
    return canvas;
  }

  #draw(): void {
    const style = getComputedStyle(this.element);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    this.#drawStrip(colour);
    this.#drawBar(colour);
  }

  #drawStrip(colour: (name: string) => string): void {
    const drawing = begun(this.#strip, IMAGES_PX);
    if (drawing === null) return;
    const { context, width } = drawing;
    const each = width / Math.max(this.#pictures.length, 1);
    this.#pictures.forEach((picture, i) => {
      if (picture !== null) context.drawImage(picture, i * each, 0, Math.max(each - 1, 1), IMAGES_PX);
    });
    this.#drawNow(context, width, IMAGES_PX, colour);
  }

  #drawBar(colour: (name: string) => string): void {
    const drawing = begun(this.#bar, BAR_PX);
    if (drawing === null) return;
    const { context, width } = drawing;
    const each = width / this.frameCount;
    context.fillStyle = colour('--surface-raised');
    context.fillRect(0, 0, width, BAR_PX);
    this.camera.doubt?.forEach((doubt, frame) => {
      const level = levelOf(doubt);
      if (level === null || doubt === null) return;
      // A sure frame is a low line, so that it differs from one without masks.
      const height = Math.max(Math.min(doubt / FULL, 1) * BAR_PX, 2);
      context.fillStyle = colour(level.colour);
      context.fillRect(frame * each, BAR_PX - height, Math.max(each - (each > 3 ? 1 : 0), 1), height);
    });
    for (const { frame, part } of this.#strokes) {
      const x = (frame + 0.5) * each;
      context.beginPath();
      context.moveTo(x - 5, 0);
      context.lineTo(x + 5, 0);
      context.lineTo(x, 8);
      context.closePath();
      context.fillStyle = colourOf(part);
      context.fill();
      context.strokeStyle = colour('--text');
      context.lineWidth = 1;
      context.stroke();
    }
    this.#drawNow(context, width, BAR_PX, colour);
  }

  #drawNow(context: CanvasRenderingContext2D, width: number, height: number, colour: (name: string) => string): void {
    context.fillStyle = colour('--accent');
    context.fillRect(((this.#frame + 0.5) / this.frameCount) * width - 1, 0, 2, height);
  }
}

/** The levels of doubt with their colours. */
export function doubtLegend(): HTMLElement {
  const entries = LEVELS.map(({ from, word, colour }) => {
    const swatch = h('span', { class: 'masks-swatch' });
    swatch.style.backgroundColor = `var(${colour})`;
    return h('span', {}, swatch, from === 0 ? word : `${word}, from ${percent(from)}`);
  });
  return h('p', { class: 'hint masks-legend' }, 'Doubt, the share of object and hand whose mask is uncertain: ', ...entries);
}
