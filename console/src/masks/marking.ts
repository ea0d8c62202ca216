import type { CameraHead } from '../playback/file/head';
import type { Read } from '../playback/file/motion';
import { Images } from '../playback/camera/images';
import { h } from '../ui/dom';
import { drawBrush, drawStroke, overlayOf } from './drawing';
import { HAND, OBJECT, type Masks } from './labels';
import { wordOf, type Part, type Stroke } from './strokes';

type Place = readonly [column: number, row: number];

/** Most columns of pixels that are drawn, however large an image is shown. */
const MOST_COLUMNS = 2048;
/** Steps of the keyboard's cursor over the width of an image. */
const STEPS = 50;
/** Least distance between points of a stroke [recorded pixels]. */
const APART_PX = 1;

const ARROWS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

/** The page around the images: its brush, and its strokes. */
export interface Desk {
  readonly part: Part;
  /** Radius of the brush [recorded pixels]. */
  readonly radius: number;
  /** True if masks are laid over the images. */
  readonly showsMasks: boolean;
  /** Strokes in an image. */
  strokes(camera: number, frame: number): readonly Stroke[];
  mark(stroke: Stroke): void;
  /** Says something to people who use a screen reader. */
  say(text: string): void;
  /** The images have to be drawn again. */
  redraw(): void;
}

/** The images of a camera, in which strokes are made with a pointer or the keyboard. */
export class Marking {
  readonly element: HTMLElement;
  readonly #canvas: HTMLCanvasElement;
  readonly #frame: HTMLElement;
  readonly #note = h('figcaption', { class: 'hint' });
  readonly #images: Images;
  readonly #resize: ResizeObserver;
  #overlay: { labels: Uint8Array; picture: OffscreenCanvas | null } | null = null;
  #shown = 0;
  #zoom = 1;
  /** Place of the cursor, and whether the keyboard moved it last. */
  #cursor: Place;
  #isKeyboard = false;
  #pointer: Place | null = null;
  /** The stroke that is being made. */
  #stroke: { part: Part; points: Place[] } | null = null;

  constructor(
    private readonly camera: CameraHead,
    private readonly index: number,
    read: Read,
    private readonly masks: Masks,
    private readonly desk: Desk,
  ) {
    this.#images = new Images(camera, read);
    const [columns, rows] = camera.size;
    this.#cursor = [Math.floor(columns / 2), Math.floor(rows / 2)];
    this.#canvas = h('canvas', {
      tabindex: '0',
      role: 'application',
      'aria-roledescription': 'image to mark',
      'aria-label': `Camera ${camera.name}`,
      'aria-describedby': 'masks-keys',
    });
    this.#canvas.style.aspectRatio = `${columns} / ${rows}`;
    this.#frame = h('div', { class: 'masks-frame' }, this.#canvas);
    this.element = h('figure', { class: 'masks-camera' }, this.#frame, this.#note);
    this.#resize = new ResizeObserver(() => this.draw(this.#shown));
    this.#resize.observe(this.#canvas);
    this.#listen();
  }

  /** The frame whose image is shown in a frame: its own, or the last one before it; null without any. */
  imageFrame(frame: number): number | null {
    const image = this.#images.indexAt(frame);
    return image === null ? null : image * this.camera.images.every;
  }

  /** Loads what a frame needs. */
  async load(frame: number): Promise<void> {
    await Promise.all([this.#images.load(frame), this.masks.load(frame)]);
  }

  /** True if a frame can be drawn. */
  has(frame: number): boolean {
    return this.#images.at(frame) !== undefined && this.masks.at(frame) !== undefined;
  }

  /** Shows the image this many times as large as there is room for; the place under the pointer stays. */
  zoom(factor: number): void {
    if (factor === this.#zoom) return;
    const [column, row] = this.#pointer ?? this.#cursor;
    const [columns, rows] = this.camera.size;
    const { scrollLeft, scrollTop, clientWidth, clientHeight } = this.#frame;
    const before = [this.#canvas.clientWidth, this.#canvas.clientHeight] as const;
    const at = [(column / columns) * before[0] - scrollLeft, (row / rows) * before[1] - scrollTop] as const;
    this.#zoom = factor;
    this.#canvas.style.width = `${100 * factor}%`;
    this.element.classList.toggle('masks-zoomed', factor > 1);
    const inside = (x: number, size: number): number => (x >= 0 && x <= size ? x : size / 2);
    this.#frame.scrollLeft = (column / columns) * this.#canvas.clientWidth - inside(at[0], clientWidth);
    this.#frame.scrollTop = (row / rows) * this.#canvas.clientHeight - inside(at[1], clientHeight);
    this.draw(this.#shown);
  }

  /** Gives the image the focus, with the cursor at a place. */
  focus([column, row]: Place): void {
    this.#cursor = [Math.round(column), Math.round(row)];
    this.#isKeyboard = true;
    this.#canvas.focus();
    this.#scrollToCursor();
    this.desk.redraw();
  }

  /** Draws a frame: the image, the masks, the strokes, and the brush. */
  draw(frame: number): void {
    this.#shown = frame;
    const context = this.#canvas.getContext('2d');
    const image = this.#images.at(frame);
    if (context === null || image === undefined) return;
    const [columns, rows] = this.camera.size;
    const wide = Math.round(this.#canvas.clientWidth * devicePixelRatio);
    const width = Math.min(Math.max(wide, 1), MOST_COLUMNS);
    const size = [width, Math.max(Math.round((width * rows) / columns), 1)] as const;
    if (this.#canvas.width !== size[0]) this.#canvas.width = size[0];
    if (this.#canvas.height !== size[1]) this.#canvas.height = size[1];
    context.fillStyle = '#14181d';
    context.fillRect(0, 0, ...size);
    if (image !== null) context.drawImage(image, 0, 0, ...size);
    const overlay = this.desk.showsMasks ? this.#overlayAt(frame) : null;
    if (overlay !== null) {
      context.imageSmoothingEnabled = false;
      context.drawImage(overlay, 0, 0, ...size);
      context.imageSmoothingEnabled = true;
    }
    const scale = width / columns;
    // Lines keep their width on the screen where fewer pixels are drawn than it has.
    const ratio = (devicePixelRatio * width) / Math.max(wide, 1);
    const own = this.imageFrame(frame);
    this.#say(frame, own);
    if (own === null) return;
    for (const stroke of this.desk.strokes(this.index, own)) drawStroke(context, stroke, scale, ratio);
    const { part, radius } = this.desk;
    if (this.#stroke !== null) drawStroke(context, this.#strokeAt(own, this.#stroke), scale, ratio);
    const isCursor = this.#isKeyboard && document.activeElement === this.#canvas;
    const place = isCursor ? this.#cursor : this.#pointer;
    if (place !== null) drawBrush(context, place, { part, radius, isCursor }, scale, ratio);
  }

  dispose(): void {
    this.#resize.disconnect();
    this.#images.dispose();
  }

  #listen(): void {
    const canvas = this.#canvas;
    canvas.addEventListener('pointerdown', (event) => this.#begin(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    canvas.addEventListener('pointerup', (event) => this.#end(event));
    // A finger that scrolls the page marks nothing.
    canvas.addEventListener('pointercancel', () => this.#drop());
    canvas.addEventListener('pointerleave', () => {
      this.#pointer = null;
      this.desk.redraw();
    });
    canvas.addEventListener('keydown', (event) => this.#key(event));
    for (const name of ['focus', 'blur']) canvas.addEventListener(name, () => this.desk.redraw());
  }

  #begin(event: PointerEvent): void {
    if (event.button !== 0 || this.imageFrame(this.#shown) === null) return;
    this.#isKeyboard = false;
    const place = this.#placeOf(event);
    this.#cursor = [Math.round(place[0]), Math.round(place[1])];
    this.#canvas.setPointerCapture(event.pointerId);
    this.#stroke = { part: event.altKey ? 'background' : this.desk.part, points: [place] };
    this.desk.redraw();
  }

  #move(event: PointerEvent): void {
    const place = this.#placeOf(event);
    this.#pointer = event.pointerType === 'touch' ? null : place;
    this.#isKeyboard = false;
    const points = this.#stroke?.points;
    const last = points?.at(-1);
    if (points !== undefined && last !== undefined && Math.hypot(place[0] - last[0], place[1] - last[1]) >= APART_PX) {
      points.push(place);
    }
    this.desk.redraw();
  }

  #end(event: PointerEvent): void {
    const stroke = this.#stroke;
    const own = this.imageFrame(this.#shown);
    this.#drop();
    if (stroke === null || own === null || event.button !== 0) return;
    this.desk.mark(this.#strokeAt(own, stroke));
  }

  #drop(): void {
    this.#stroke = null;
    this.desk.redraw();
  }

  #key(event: KeyboardEvent): void {
    const arrow = ARROWS[event.key];
    if (event.ctrlKey || event.metaKey || (arrow === undefined && event.key !== 'Enter')) return;
    event.preventDefault();
    this.#isKeyboard = true;
    if (arrow === undefined) {
      const own = this.imageFrame(this.#shown);
      const part = event.altKey ? 'background' : this.desk.part;
      if (own !== null && !event.repeat) this.desk.mark(this.#strokeAt(own, { part, points: [this.#cursor] }));
      return;
    }
    const [columns, rows] = this.camera.size;
    const step = event.shiftKey ? 1 : Math.max(Math.round(columns / STEPS), 1);
    const [x, y] = this.#cursor;
    this.#cursor = [held(x + step * arrow[0], columns), held(y + step * arrow[1], rows)];
    this.#scrollToCursor();
    this.desk.say(`${this.#cursor.join(', ')}${this.#labelAt(this.#cursor)}`);
    this.desk.redraw();
  }

  /** What the masks have at a place, in words. */
  #labelAt([column, row]: Place): string {
    const labels = this.masks.at(this.#shown);
    if (labels === null || labels === undefined) return '';
    const [columns, rows] = this.camera.images.size;
    const [x, y] = [
      held(Math.floor(((column + 0.5) * columns) / this.camera.size[0]), columns),
      held(Math.floor(((row + 0.5) * rows) / this.camera.size[1]), rows),
    ];
    const label = labels[y * columns + x];
    return label === OBJECT ? ', on the object' : label === HAND ? ', on the hand' : '';
  }

  #scrollToCursor(): void {
    const { clientWidth, clientHeight } = this.#canvas;
    const x = (this.#cursor[0] / this.camera.size[0]) * clientWidth;
    const y = (this.#cursor[1] / this.camera.size[1]) * clientHeight;
    const frame = this.#frame;
    const into = (at: number, from: number, size: number): number =>
      at < from || at > from + size ? at - size / 2 : from;
    frame.scrollLeft = into(x, frame.scrollLeft, frame.clientWidth);
    frame.scrollTop = into(y, frame.scrollTop, frame.clientHeight);
  }

  #strokeAt(frame: number, { part, points }: { part: Part; points: readonly Place[] }): Stroke {
    return { part, camera: this.index, frame, points, radius_px: this.desk.radius };
  }

  /** Recorded pixel at which a pointer is. */
  #placeOf(event: PointerEvent): Place {
    const { left, top, width, height } = this.#canvas.getBoundingClientRect();
    const [columns, rows] = this.camera.size;
    return [
      held(((event.clientX - left) / Math.max(width, 1)) * columns - 0.5, columns),
      held(((event.clientY - top) / Math.max(height, 1)) * rows - 0.5, rows),
    ];
  }

  #overlayAt(frame: number): OffscreenCanvas | null {
    const labels = this.masks.at(frame);
    if (labels === null || labels === undefined) return null;
    if (this.#overlay?.labels !== labels) {
      this.#overlay = { labels, picture: overlayOf(labels, this.camera.images.size) };
    }
    return this.#overlay.picture;
  }

  #say(frame: number, own: number | null): void {
    const { name, images } = this.camera;
    const said = ((): string => {
      if (images.lengths.length === 0) return ': its images were left out for lack of space.';
      if (own === null) return ': no image was recorded here.';
      return own === frame ? '' : `: the image is of frame ${own}; marks are made in it.`;
    })();
    const text = `Camera ${name}${said}`;
    if (this.#note.textContent !== text) this.#note.textContent = text;
  }
}

/** A stroke in words. */
export function described({ part, frame, points }: Stroke, camera: string): string {
  const [[x, y] = [0, 0]] = points;
  const place = `${Math.round(x)}, ${Math.round(y)}`;
  const kind = points.length === 1 ? `click at ${place}` : `stroke from ${place}`;
  return `${wordOf(part)}, camera ${camera}, frame ${frame}, ${kind}`;
}

/** A column or row within the image. */
function held(value: number, size: number): number {
  return Math.min(Math.max(value, 0), size - 1);
}
