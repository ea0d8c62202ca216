import { h } from '../../ui/dom';
import { millimetres } from '../../ui/format';
import { begun, onPressed } from '../canvas';
import type { Clock } from '../clock';
import type { Errors } from './errors';
import { FOOT, LEFT, RIGHT, drawLanes, frameAt, xOf, type Lane, type Span } from './lanes';
import { Legend } from './legend';
import type { HandSpeed } from './speed';
import './axis.css';

/** Heights of lanes [pixels]. */
const ERROR_HEIGHT = 116;
const SPEED_HEIGHT = 48;
/** Height of the axis without lanes [pixels]. */
const LEAST_HEIGHT = 8;
/** Colours of hands. */
const HAND_SERIES = ['--series-5', '--series-4', '--series-3'] as const;

/**
 * All that is known along time, above one axis: errors of a prediction beside baselines, speeds of hands,
 * and which frames were for fitting. A place that is pressed is shown.
 */
export class TimeAxis {
  readonly element: HTMLElement;
  readonly #canvas = h('canvas', { class: 'axis-canvas', 'aria-hidden': 'true' });
  /** For keys, and for those who do not see the drawing: it lies unseen over that. */
  readonly #slider: HTMLInputElement;
  readonly #cursor = h('div', { class: 'axis-cursor' });
  readonly #pointed = h('div', { class: 'axis-pointed', hidden: true });
  readonly #strip: HTMLElement;
  readonly #legend = new Legend();
  readonly #resize = new ResizeObserver(() => this.#draw());
  readonly #dark = matchMedia('(prefers-color-scheme: dark)');
  #span: Span;
  #errors: Errors | null = null;
  #speeds: readonly HandSpeed[] = [];

  constructor(private readonly clock: Clock, trainFrameCount: number) {
    const { frameCount, fps } = clock;
    this.#span = { frameCount, fps, trainFrameCount };
    this.#slider = h('input', { type: 'range', min: 0, max: frameCount - 1, step: 1, 'aria-label': 'Frame' });
    this.#slider.addEventListener('input', () => this.#seek(this.#slider.valueAsNumber));
    this.#slider.style.left = `${LEFT}px`;
    this.#slider.style.right = `${RIGHT}px`;
    this.#strip = h('div', { class: 'axis-strip' }, this.#canvas, this.#slider, this.#pointed, this.#cursor);
    onPressed(this.#strip, (share) => {
      this.#slider.focus({ preventScroll: true });
      this.#seek(this.#frameAt(share * this.#strip.clientWidth));
    });
    this.#strip.addEventListener('pointermove', this.#point);
    this.#strip.addEventListener('pointerleave', () => (this.#pointed.hidden = true));
    this.element = h('div', { class: 'axis' }, this.#strip, this.#legend.element);
    this.#resize.observe(this.#strip);
    this.#dark.addEventListener('change', this.#draw);
  }

  /** Shows the errors of a prediction from now on, whose frames for fitting are these. */
  setErrors(errors: Errors, trainFrameCount: number): void {
    this.#errors = errors;
    this.#span = { ...this.#span, trainFrameCount };
    this.#legend.set(errors, this.#speeds, HAND_SERIES);
    this.#draw();
  }

  /** Shows the speeds of hands from now on. */
  setSpeeds(speeds: readonly HandSpeed[]): void {
    this.#speeds = speeds;
    this.#legend.set(this.#errors, speeds, HAND_SERIES);
    this.#draw();
  }

  /** Shows where the clock is, which `text` says in words. */
  show(text: string): void {
    const { frame } = this.clock;
    this.#slider.value = String(frame);
    this.#slider.setAttribute('aria-valuetext', text);
    this.#cursor.style.transform = `translateX(${this.#x(frame)}px)`;
    this.#legend.show(frame, frame < this.#span.trainFrameCount);
  }

  dispose(): void {
    this.#resize.disconnect();
    this.#dark.removeEventListener('change', this.#draw);
  }

  #seek(frame: number): void {
    this.clock.pause();
    this.clock.seek(frame);
  }

  #x(frame: number): number {
    return xOf(frame, this.#span, this.#strip.clientWidth);
  }

  #frameAt(x: number): number {
    const frame = frameAt(x, this.#span, this.#strip.clientWidth);
    return Math.min(Math.max(frame, 0), this.clock.frameCount - 1);
  }

  get #lanes(): Lane[] {
    const errors = this.#errors;
    const lanes: Lane[] = [];
    if (errors?.main != null) {
      const marks = [errors.worst, errors.worstOfFuture].flatMap((place) => {
        return place === null ? [] : [{ frame: place.frame, value: place.error }];
      });
      lanes.push({ height: ERROR_HEIGHT, unit: 'mm', scale: 1000, lines: errors.curves, levels: errors.baselines, marks });
    }
    if (this.#speeds.length > 0) {
      const lines = this.#speeds.map(({ values }, i) => ({ values, series: HAND_SERIES[i]! }));
      lanes.push({ height: SPEED_HEIGHT, unit: 'm/s', scale: 1, lines, levels: [], marks: [] });
    }
    return lanes;
  }

  readonly #draw = (): void => {
    const lanes = this.#lanes;
    const height = Math.max(lanes.reduce((sum, lane) => sum + lane.height, 0), LEAST_HEIGHT) + FOOT;
    this.#canvas.style.height = `${height}px`;
    const drawing = begun(this.#canvas, height);
    if (drawing === null) return;
    const style = getComputedStyle(this.element);
    drawLanes(drawing.context, drawing.width, lanes, this.#span, (name) => style.getPropertyValue(name).trim());
    this.#cursor.style.transform = `translateX(${this.#x(this.clock.frame)}px)`;
  };

  /** Says what is at the place that the pointer is over. */
  readonly #point = (event: PointerEvent): void => {
    const frame = this.#frameAt(event.clientX - this.#strip.getBoundingClientRect().left);
    const error = this.#errors?.main?.values[frame] ?? null;
    const seconds = `${(frame / this.clock.fps).toFixed(2)} s`;
    this.#pointed.hidden = event.pointerType === 'touch';
    this.#pointed.textContent = error === null ? seconds : `${seconds}, ${millimetres(error)}`;
    this.#pointed.classList.toggle('axis-pointed-left', frame > 0.7 * this.clock.frameCount);
    this.#pointed.style.left = `${this.#x(frame)}px`;
  };
}
