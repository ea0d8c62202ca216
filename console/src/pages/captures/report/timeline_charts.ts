import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import { h } from '../../../ui/dom';
import { WHOLE, inks, widthOf, type Inks } from '../../parts/plot';
import { FRAME_STATES, bandsSummary, summary, type Band, type FrameState, type Line, type Timeline } from './timelines';

/** Height of a figure, of a band, and of the axis below the last one [px]. */
const HEIGHT = 92;
const BAND = 18;
const AXIS = 34;
/** Width of the axis at the left, the same in all, so that frames lie below each other [px]. */
const LEFT = 84;
const RIGHT = 14;

/** Variables of the styles by which what is wrong with a frame is painted. */
const STATE_INKS: Record<FrameState, string> = {
  fine: '--good-surface',
  late: '--series-5',
  'mask jumps': '--series-1',
  repeated: '--series-2',
  'mask empty': '--series-4',
  missing: '--bad',
};

/** Number of pages that have had figures: each has its own key. */
let pages = 0;

export interface TimelineOptions {
  readonly bands: readonly Band[];
  readonly timelines: readonly Timeline[];
  readonly frameCount: number;
  /** Frames from here on are only predicted. */
  readonly trainFrameCount: number;
  /** 0: unknown. */
  readonly fps: number;
  /** Called with a frame that was clicked; null: nothing happens. */
  readonly onFrame: ((frame: number) => void) | null;
}

/** A figure: what it says to those who do not see it, its axis at the left, and what lies below its lines. */
interface Figure {
  readonly label: string;
  readonly axis: uPlot.Axis;
  readonly range: [number, number];
  readonly under: (plot: uPlot) => void;
  /** Called with the frame that is pointed at, or null. */
  readonly tell: (frame: number | null) => void;
}

/** Figures over frames below each other, with one axis: a frame that is pointed at is marked in all of them. */
export class TimelineCharts {
  readonly element = h('div', { class: 'timelines card' });
  /** The frame that is pointed at. */
  readonly #at = h('p', { class: 'timeline-at', 'aria-hidden': 'true' });
  #drawn: { readonly plot: uPlot; readonly place: HTMLElement }[] = [];
  readonly #resized = new ResizeObserver(() => this.#resize());
  readonly #scheme = matchMedia('(prefers-color-scheme: dark)');
  readonly #repaint = (): void => this.#draw();
  /** Ties the marks of the figures together. */
  readonly #key = `timelines-${(pages += 1)}`;

  constructor(private readonly options: TimelineOptions) {
    this.#resized.observe(this.element);
    this.#scheme.addEventListener('change', this.#repaint);
    // Widths are known once it is in the page.
    requestAnimationFrame(() => this.#draw());
  }

  dispose(): void {
    this.#resized.disconnect();
    this.#scheme.removeEventListener('change', this.#repaint);
    this.#clear();
  }

  #clear(): void {
    for (const { plot } of this.#drawn) plot.destroy();
    this.#drawn = [];
  }

  #draw(): void {
    this.#clear();
    this.element.replaceChildren(this.#at);
    const { bands, timelines } = this.options;
    const ink = inks();
    if (bands.length > 0) this.#drawBands(bands, ink, timelines.length === 0);
    timelines.forEach((timeline, index) => this.#drawLines(timeline, ink, index === timelines.length - 1));
  }

  #drawLines(timeline: Timeline, ink: Inks, isLast: boolean): void {
    const { title, meaning, lines, word, limit } = timeline;
    const keys = lines.map(({ name, values }, index) => {
      const value = h('span', { class: 'timeline-value' });
      const swatch = h('span', { class: 'timeline-swatch' });
      swatch.style.backgroundColor = ink.series[index % ink.series.length] ?? '';
      const tell = (frame: number | null): void => {
        const own = frame === null ? null : (values[frame] ?? null);
        value.textContent = own === null ? '' : word(own);
      };
      return { element: h('span', { class: 'timeline-key' }, swatch, h('bdi', {}, name), ' ', value), tell };
    });
    const place = this.#place(title, meaning, ...keys.map(({ element }) => element));
    const largest = lines.flatMap(({ values }) => values).reduce<number>((most, value) => Math.max(most, value ?? 0), limit ?? 0);
    const top = timeline.top ?? (largest > 0 ? 1.05 * largest : 1);
    this.#plot(place, ink, HEIGHT, isLast, lines, {
      label: summary(timeline),
      axis: { splits: () => [0, top / 2, top], values: (_plot, splits) => splits.map(word) },
      range: [0, top],
      under: (plot) => {
        if (limit !== null) across(plot, plot.valToPos(limit, 'y', true), ink.of('--warn'));
      },
      tell: (frame) => keys.forEach((key) => key.tell(frame)),
    });
  }

  #drawBands(bands: readonly Band[], ink: Inks, isLast: boolean): void {
    const used = FRAME_STATES.filter((state) => state !== 'fine' && bands.some(({ states }) => states.includes(state)));
    const keys = used.map((state) => {
      const swatch = h('span', { class: 'timeline-swatch' });
      swatch.style.backgroundColor = `var(${STATE_INKS[state]})`;
      return h('span', { class: 'timeline-key' }, swatch, state);
    });
    const meaning = used.length === 0 ? 'of each camera: no gap, no repeat, no jump' : 'of each camera';
    const rows = bands.length;
    this.#plot(this.#place('Frames', meaning, ...keys), ink, rows * BAND + 8, isLast, [{ name: '', values: [] }], {
      label: bandsSummary(bands),
      axis: {
        splits: () => bands.map((_, row) => rows - row - 0.5),
        values: () => bands.map(({ name }) => short(name)),
        grid: { show: false },
        ticks: { show: false },
      },
      range: [0, rows],
      under: (plot) => bands.forEach(({ states }, row) => paintBand(plot, states, rows - row, ink)),
      tell: () => undefined,
    });
  }

  /** The place of a figure, with its title and the keys of its lines. */
  #place(title: string, meaning: string, ...keys: HTMLElement[]): HTMLElement {
    const caption = h('figcaption', {}, h('strong', {}, title), h('span', { class: 'muted' }, ` ${meaning}`), ...keys);
    const place = h('figure', {}, caption);
    this.element.append(place);
    return place;
  }

  #plot(
    place: HTMLElement,
    ink: Inks,
    height: number,
    isLast: boolean,
    lines: readonly Line[],
    of: Figure,
  ): void {
    const { frameCount, trainFrameCount, fps, onFrame } = this.options;
    const frames = Array.from({ length: frameCount }, (_, frame) => frame);
    const series = lines.map((_, index) => ({ stroke: ink.series[index % ink.series.length] ?? ink.text, width: 1.5, points: { show: false } }));
    const axis = { stroke: ink.text, font: '11px system-ui, sans-serif', grid: { stroke: ink.grid, width: 1 }, ticks: { stroke: ink.grid, width: 1 } };
    const seconds = (frame: number): string => (fps > 0 ? `${frame} (${(frame / fps).toFixed(1)} s)` : String(frame));
    const plot = new uPlot(
      {
        width: widthOf(place),
        height: height + (isLast ? AXIS : 14),
        padding: [8, RIGHT, isLast ? 0 : 6, 0],
        legend: { show: false },
        cursor: { sync: { key: this.#key }, y: false, drag: { x: false, y: false }, points: { size: 6 } },
        scales: { x: { time: false, range: () => [0, Math.max(frameCount - 1, 1)] }, y: { range: () => of.range } },
        axes: [
          {
            ...axis,
            incrs: WHOLE,
            space: 90,
            size: isLast ? AXIS : 0,
            values: (_plot, splits) => splits.map((split) => (isLast ? seconds(split) : '')),
            ticks: { show: isLast, stroke: ink.grid },
          },
          { ...axis, size: LEFT, ...of.axis },
        ],
        series: [{}, ...series],
        hooks: {
          drawAxes: [
            (own) => {
              of.under(own);
              if (trainFrameCount > 0 && trainFrameCount < frameCount) {
                down(own, own.valToPos(trainFrameCount - 0.5, 'x', true), ink.text);
              }
            },
          ],
          setCursor: [
            (own) => {
              const frame = own.cursor.idx ?? null;
              of.tell(frame);
              this.#at.textContent = frame === null ? '' : `frame ${seconds(frame)}`;
            },
          ],
        },
      },
      [frames, ...lines.map(({ values }) => frames.map((frame) => values[frame] ?? null))],
      place,
    );
    plot.root.setAttribute('role', 'img');
    plot.root.setAttribute('aria-label', of.label);
    if (onFrame !== null) {
      plot.over.style.cursor = 'pointer';
      plot.over.addEventListener('click', () => {
        const frame = plot.cursor.idx;
        if (frame !== null && frame !== undefined) onFrame(frame);
      });
    }
    this.#drawn.push({ plot, place });
  }

  /** Figures are as wide as the page lets them be. */
  #resize(): void {
    for (const { plot, place } of this.#drawn) {
      const width = widthOf(place);
      if (plot.width !== width) plot.setSize({ width, height: plot.height });
    }
  }
}

/** Paints the frames of a camera as a band whose upper edge is at `top`. */
function paintBand(plot: uPlot, states: readonly FrameState[], top: number, ink: Inks): void {
  const { ctx } = plot;
  const y = plot.valToPos(top, 'y', true) + 2 * devicePixelRatio;
  const height = plot.valToPos(top - 1, 'y', true) - y - 2 * devicePixelRatio;
  const [left, right] = [plot.bbox.left, plot.bbox.left + plot.bbox.width];
  ctx.save();
  ctx.fillStyle = ink.of(STATE_INKS.fine);
  ctx.fillRect(left, y, right - left, height);
  states.forEach((state, frame) => {
    if (state === 'fine') return;
    const from = Math.max(plot.valToPos(frame - 0.5, 'x', true), left);
    const to = Math.min(plot.valToPos(frame + 0.5, 'x', true), right);
    ctx.fillStyle = ink.of(STATE_INKS[state]);
    ctx.fillRect(from, y, Math.max(to - from, 1.5 * devicePixelRatio), height);
  });
  ctx.restore();
}

function across({ ctx, bbox }: uPlot, y: number, color: string): void {
  dashed(ctx, color, bbox.left, y, bbox.left + bbox.width, y);
}

function down({ ctx, bbox }: uPlot, x: number, color: string): void {
  dashed(ctx, color, x, bbox.top, x, bbox.top + bbox.height);
}

function dashed(ctx: CanvasRenderingContext2D, color: string, x0: number, y0: number, x1: number, y1: number): void {
  ctx.save();
  ctx.strokeStyle = color;
  ctx.lineWidth = devicePixelRatio;
  ctx.setLineDash([4 * devicePixelRatio, 4 * devicePixelRatio]);
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(x1, y1);
  ctx.stroke();
  ctx.restore();
}

/** A name that fits beside a band. */
function short(name: string): string {
  const letters = [...name];
  return letters.length > 11 ? `${letters.slice(0, 10).join('')}…` : name;
}
