import { h } from '../ui/dom';
import { millimetres } from '../ui/format';
import { begun, onPressed } from './canvas';
import type { FrameErrors, Prediction } from './prediction';

const HEIGHT = 96;
/** The errors that are drawn, with the words and the colours for them. */
const LINES = [
  { of: 'track', label: 'Tracks', series: '--series-1' },
  { of: 'chamfer', label: 'Surface L1', series: '--series-2' },
] as const;

/** The error of each frame under the time line. A place in it that is pointed at is shown. */
export class ErrorChart {
  readonly element: HTMLElement;
  readonly #canvas = h('canvas', { class: 'playback-chart-canvas', 'aria-hidden': 'true' });
  readonly #values = h('p', { class: 'playback-errors' });
  readonly #resize = new ResizeObserver(() => this.#draw());
  #frame = 0;

  constructor(
    private readonly prediction: Prediction,
    private readonly frameCount: number,
    seek: (frame: number) => void,
  ) {
    this.element = h('div', { class: 'playback-chart' }, this.#canvas, this.#values);
    onPressed(this.#canvas, (share) => seek(Math.round(share * (frameCount - 1))));
    this.#resize.observe(this.#canvas);
  }

  /** Marks a frame, and says its errors. */
  show(frame: number): void {
    this.#frame = frame;
    const errors = this.prediction.errors(frame);
    const isTraining = frame < this.prediction.trainFrameCount;
    const texts = LINES.filter(({ of }) => this.#has(of)).map(({ of, label, series }) => {
      const swatch = h('span', { class: 'playback-swatch' });
      swatch.style.backgroundColor = `var(${series})`;
      return h('span', {}, swatch, `${label} ${millimetres(errors[of])}`);
    });
    const time = isTraining ? 'fitted to this frame' : 'not fitted to this frame';
    this.#values.replaceChildren(h('span', {}, `Error (${time}):`), ...texts);
    this.#draw();
  }

  /** Mean errors over frames in words, for those who do not see the curves. */
  summary(): string {
    const { trainFrameCount, startFrame } = this.prediction;
    // The frame in which a prediction begins is not predicted.
    const first = startFrame + 1;
    const mean = (of: keyof FrameErrors, from: number, to: number): number | null => {
      const values = this.#all(of).slice(from, to).filter((value) => value !== null);
      return values.length === 0 ? null : values.reduce((sum, value) => sum + value, 0) / values.length;
    };
    const parts = LINES.filter(({ of }) => this.#has(of)).map(({ of, label }) => {
      const [fitted, later] = [mean(of, first, trainFrameCount), mean(of, Math.max(trainFrameCount, first), this.frameCount)];
      return `${label}: ${millimetres(fitted)} over fitted frames, ${millimetres(later)} over others`;
    });
    return parts.join('. ');
  }

  dispose(): void {
    this.#resize.disconnect();
  }

  #all(of: keyof FrameErrors): (number | null)[] {
    return Array.from({ length: this.frameCount }, (_, frame) => this.prediction.errors(frame)[of]);
  }

  #has(of: keyof FrameErrors): boolean {
    return this.#all(of).some((value) => value !== null);
  }

  #draw(): void {
    const drawing = begun(this.#canvas, HEIGHT);
    if (drawing === null) return;
    const { context, width } = drawing;
    const style = getComputedStyle(this.element);
    const colour = (name: string): string => style.getPropertyValue(name).trim();
    const x = (frame: number): number => (frame / Math.max(this.frameCount - 1, 1)) * width;
    const values = LINES.map(({ of }) => this.#all(of));
    const most = Math.max(...values.flat().map((value) => value ?? 0), 1e-6);
    const y = (value: number): number => HEIGHT - 3 - (value / most) * (HEIGHT - 18);
    context.fillStyle = colour('--surface-raised');
    context.fillRect(0, 0, x(Math.max(this.prediction.trainFrameCount - 0.5, 0)), HEIGHT);
    context.fillStyle = colour('--muted');
    context.font = '11px system-ui, sans-serif';
    context.fillText(millimetres(most), 4, 12);
    LINES.forEach(({ series }, line) => {
      context.beginPath();
      let isDown = false;
      values[line]!.forEach((value, frame) => {
        if (value === null) isDown = false;
        else if (isDown) context.lineTo(x(frame), y(value));
        else context.moveTo(x(frame), y(value));
        isDown = value !== null;
      });
      context.strokeStyle = colour(series);
      context.lineWidth = 1.5;
      context.stroke();
    });
    context.fillStyle = colour('--accent');
    context.fillRect(x(this.#frame) - 1, 0, 2, HEIGHT);
  }
}
