import { h } from '../ui/dom';
import type { Child } from '../ui/dom';
import { SPEEDS, type Clock } from './clock';

/** Buttons and speed of a clock, and where it is in words. */
export class Transport {
  readonly element: HTMLElement;
  readonly #play: HTMLButtonElement;
  readonly #output = h('output', { class: 'playback-time' });

  /** Frames before `trainFrameCount` are for fitting. `more` stands behind the rest. */
  constructor(
    private readonly clock: Clock,
    public trainFrameCount: number,
    ...more: Child[]
  ) {
    const button = (text: string, label: string, onclick: () => void): HTMLButtonElement =>
      h('button', { type: 'button', 'aria-label': label, title: label, onclick }, text);
    this.#play = h('button', { type: 'button', class: 'primary playback-play', onclick: () => this.toggle() }, 'Play');
    const speed = h('select', { 'aria-label': 'Speed' }, ...SPEEDS.map((value) =>
      h('option', { value, selected: value === clock.speed }, `${value} ×`)));
    speed.addEventListener('change', () => (clock.speed = Number(speed.value)));
    this.element = h('div', { class: 'row' },
      this.#play,
      button('|◂', 'First frame', () => clock.step(-clock.frameCount)),
      button('◂', 'Frame before', () => clock.step(-1)),
      button('▸', 'Next frame', () => clock.step(1)),
      button('▸|', 'Last frame', () => clock.step(clock.frameCount)),
      speed, this.#output, ...more);
  }

  toggle(): void {
    if (this.clock.isPlaying) this.clock.pause();
    else this.clock.play();
  }

  /** Shows where the clock is, and gives it in words. */
  show(): string {
    const { frame, frameCount, fps, isPlaying } = this.clock;
    this.#play.textContent = isPlaying ? 'Pause' : 'Play';
    const part = frame < this.trainFrameCount ? 'for fitting' : 'future';
    const text = `frame ${frame} of ${frameCount - 1}, ${(frame / fps).toFixed(2)} s, ${part}`;
    this.#output.textContent = text;
    return text;
  }
}
