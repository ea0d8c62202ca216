import { h } from '../ui/dom';
import type { Clock } from './clock';
import { Transport } from './transport';

/** Buttons, speed and a slider for the frame that is shown. */
export class Timeline {
  readonly element: HTMLElement;
  readonly #transport: Transport;
  readonly #slider: HTMLInputElement;

  constructor(
    private readonly clock: Clock,
    trainFrameCount: number,
  ) {
    this.#transport = new Transport(clock, trainFrameCount);
    this.#slider = h('input', { type: 'range', min: 0, max: clock.frameCount - 1, step: 1, 'aria-label': 'Frame' });
    this.#slider.addEventListener('input', () => {
      clock.pause();
      clock.seek(this.#slider.valueAsNumber);
    });
    this.element = h('div', { class: 'playback-timeline' }, this.#transport.element, this.#slider);
  }

  toggle(): void {
    this.#transport.toggle();
  }

  /** Shows where the clock is. */
  show(): void {
    this.#slider.setAttribute('aria-valuetext', this.#transport.show());
    this.#slider.value = String(this.clock.frame);
  }
}
