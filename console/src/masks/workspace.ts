import type { PageContext } from '../page';
import { Clock } from '../playback/clock';
import type { PlaybackFile } from '../playback/file/file';
import type { SequenceHead } from '../playback/file/head';
import { Timeline } from '../playback/timeline';
import { h } from '../ui/dom';
import type { Tools } from './brushes';
import { nextDoubtful } from './doubt';
import { Masks } from './labels';
import { Marking } from './marking';
import type { Stroke, Strokes } from './strokes';
import { TimeStrip, doubtLegend } from './time_strip';

/** Turn of the wheel for a step of magnification [pixels of scrolling]. */
const TURN = 80;

/** What the images of a playback are marked with. */
export interface Surroundings {
  readonly context: PageContext;
  readonly tools: Tools;
  readonly strokes: Strokes;
  mark(stroke: Stroke): void;
  fail(error: unknown): void;
  /** The shown frame has changed. */
  moved(frame: number): void;
}

/** Images of all cameras with their masks, along one time axis. */
export class Workspace {
  readonly element: HTMLElement;
  /** Names of the cameras. */
  readonly names: readonly string[];
  /** True if there are masks. */
  readonly hasMasks: boolean;
  readonly clock: Clock;
  readonly #cameras: readonly Marking[];
  readonly #strips: readonly TimeStrip[];
  readonly #timeline: Timeline;
  #isDrawing = false;
  #loading = -1;
  /** Turn of the wheel since the last step of magnification. */
  #turned = 0;

  constructor(
    file: PlaybackFile,
    sequence: SequenceHead,
    frame: number,
    private readonly around: Surroundings,
  ) {
    const { tools, strokes } = around;
    const read = file.read.bind(file);
    this.names = sequence.cameras.map(({ name }, index) => name || String(index));
    this.clock = new Clock(sequence.frame_count, sequence.fps, frame, () => this.#changed());
    this.#timeline = new Timeline(this.clock, sequence.train_frame_count);
    const masks = sequence.cameras.map((camera) => new Masks(camera, read));
    this.hasMasks = masks.some(({ isThere }) => isThere);
    const desk = {
      get part() {
        return tools.part;
      },
      get radius() {
        return tools.radius;
      },
      get showsMasks() {
        return tools.showsMasks;
      },
      strokes: (camera: number, own: number) => strokes.in(camera, own),
      mark: around.mark,
      say: (text: string) => around.context.announce(text),
      redraw: () => this.redraw(),
    };
    this.#cameras = sequence.cameras.map((camera, i) => new Marking(camera, i, read, masks[i]!, desk));
    const seek = (other: number): void => this.seek(other);
    this.#strips = sequence.cameras.map((camera, i) => new TimeStrip(camera, read, masks[i]!, sequence.frame_count, seek));
    const doubts = sequence.cameras.flatMap(({ doubt }) => (doubt ? [doubt] : []));
    const next = h('button', { type: 'button', class: 'small' }, 'Next doubtful frame');
    next.addEventListener('click', () => {
      const found = nextDoubtful(doubts, this.clock.frame);
      if (found === null) around.context.announce('No frame is doubtful.');
      else this.seek(found);
    });
    const isDoubtful = nextDoubtful(doubts, 0) !== null;
    const images = h('div', { class: 'masks-cameras' }, ...this.#cameras.map(({ element }) => element));
    images.addEventListener('wheel', (event) => this.#wheel(event), { passive: false });
    this.element = h(
      'div',
      { class: 'masks-work' },
      images,
      h('section', { class: 'masks-times', 'aria-label': 'Time' },
        this.#timeline.element,
        ...this.#strips.map(({ element }) => element),
        h('div', { class: 'row' }, isDoubtful && next, doubts.length > 0 && doubtLegend())),
    );
    this.#changed();
  }

  /** Shows another frame, and stops there. */
  seek(frame: number): void {
    this.clock.pause();
    this.clock.seek(frame);
  }

  /** Shows a stroke, with the cursor at its start. */
  reveal({ camera, frame, points }: Stroke): void {
    this.seek(frame);
    if (points[0] !== undefined) this.#cameras[camera]?.focus(points[0]);
  }

  toggle(): void {
    this.#timeline.toggle();
  }

  zoom(factor: number): void {
    for (const camera of this.#cameras) camera.zoom(factor);
  }

  /** Draws the images and strips again, before the next picture of the screen. */
  redraw(): void {
    if (this.#isDrawing) return;
    this.#isDrawing = true;
    requestAnimationFrame((now) => {
      this.#isDrawing = false;
      if (this.around.context.signal.aborted) return;
      this.clock.tick(now, (frame) => this.#isHere(frame));
      const { frame } = this.clock;
      for (const camera of this.#cameras) camera.draw(frame);
      if (this.clock.isPlaying) this.redraw();
    });
  }

  /** Shows strokes that have changed. */
  showStrokes(): void {
    const { all } = this.around.strokes;
    this.#strips.forEach((strip, i) => strip.show(this.clock.frame, all.filter(({ camera }) => camera === i)));
    this.redraw();
  }

  dispose(): void {
    this.clock.pause();
    for (const view of [...this.#cameras, ...this.#strips]) view.dispose();
  }

  /** With Ctrl held the wheel magnifies, as it does pages. */
  #wheel(event: WheelEvent): void {
    if (!event.ctrlKey) return;
    event.preventDefault();
    this.#turned += event.deltaY;
    if (Math.abs(this.#turned) < TURN) return;
    this.around.tools.zoomBy(this.#turned < 0 ? 1 : -1);
    this.#turned = 0;
  }

  #changed(): void {
    this.#timeline.show();
    this.showStrokes();
    this.#isHere(this.clock.frame);
    this.around.moved(this.clock.frame);
  }

  /** True if a frame can be drawn; it is loaded otherwise, and what follows it while it is played. */
  #isHere(frame: number): boolean {
    const isHere = this.#cameras.every((camera) => camera.has(frame));
    if (isHere && !this.clock.isPlaying) return true;
    if (this.#loading === frame) return isHere;
    this.#loading = frame;
    Promise.all(this.#cameras.map((camera) => camera.load(frame))).then(
      () => {
        if (this.#loading === frame) this.#loading = -1;
        this.redraw();
      },
      (error: unknown) => {
        this.#loading = -1;
        this.clock.pause();
        this.around.fail(error);
      },
    );
    return isHere;
  }
}
