import { h } from '../../ui/dom';
import { millimetres } from '../../ui/format';
import type { Errors } from './errors';
import type { HandSpeed } from './speed';

/** What the lines of a time axis mean, with their numbers in the frame that is shown. */
export class Legend {
  readonly element = h('div', { class: 'axis-legend' });
  /** What changes with the frame. */
  #frames: ((frame: number, isFitted: boolean) => void)[] = [];

  /** Explains these lines. */
  set(errors: Errors | null, speeds: readonly HandSpeed[], handSeries: readonly string[]): void {
    this.#frames = [];
    this.element.replaceChildren(
      ...(errors === null ? [] : [this.#errorsOf(errors)]),
      ...(errors === null || errors.baselines.length === 0 ? [] : [baselinesOf(errors)]),
      ...(speeds.length === 0 ? [] : [this.#speedsOf(speeds, handSeries)]),
    );
  }

  /** Shows the numbers of a frame. */
  show(frame: number, isFitted: boolean): void {
    this.#frames.forEach((each) => each(frame, isFitted));
  }

  #errorsOf(errors: Errors): HTMLElement {
    const { curves } = errors;
    const part = h('span');
    this.#frames.push((_, isFitted) => {
      part.textContent = isFitted ? 'Error (fitted to this frame):' : 'Error (not fitted to this frame):';
    });
    const items = curves.map((curve) => {
      const { train, future } = errors.means(curve);
      const now = h('b');
      this.#frames.push((frame) => (now.textContent = millimetres(curve.values[frame])));
      return item(curve.label, curve.title, curve.series, false, now, means(train, future));
    });
    return h('p', { class: 'axis-errors' }, part, ...items);
  }

  #speedsOf(speeds: readonly HandSpeed[], series: readonly string[]): HTMLElement {
    const items = speeds.map(({ label, values }, i) => {
      const now = h('b');
      this.#frames.push((frame) => {
        const speed = values[frame] ?? null;
        now.textContent = speed === null ? '–' : `${speed.toFixed(2)} m/s`;
      });
      return item(label, 'Speed of the middle of the control points.', series[i]!, false, now);
    });
    return h('p', {}, 'Speed:', ...items);
  }
}

function baselinesOf({ baselines, main }: Errors): HTMLElement {
  const title = `Mean error of a simpler prediction, measured as ${main?.label ?? 'this'}, over the whole capture.`;
  const items = baselines.map(({ label, series, train, future }) => item(label, title, series, true, means(train, future)));
  return h('p', {}, 'For comparison:', ...items);
}

function item(label: string, title: string, series: string, isDashed: boolean, ...values: (HTMLElement | null)[]): HTMLElement {
  const swatch = h('span', { class: isDashed ? 'axis-swatch axis-dashed' : 'axis-swatch' });
  swatch.style.borderColor = `var(${series})`;
  return h('span', { title }, swatch, label, ...values.flatMap((value) => [' ', value]));
}

/** Mean errors over both parts of the time, in words. */
function means(train: number | null, future: number | null): HTMLElement | null {
  const parts = [
    ...(train === null ? [] : [`fitted ${millimetres(train)}`]),
    ...(future === null ? [] : [`future ${millimetres(future)}`]),
  ];
  return parts.length === 0 ? null : h('span', { class: 'muted' }, `(mean: ${parts.join(', ')})`);
}
