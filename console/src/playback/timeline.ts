import { h } from '../ui/dom';
import { SPEEDS, type Clock } from './clock';

/** Buttons, speed and a slider for the frame that is shown. */
export class Timeline {
  readonly element: HTMLElement;
  readonly #play: HTMLButtonElement;
  readonly #slider: HTMLInputElement;
  readonly #output = h('output', { class: 'playback-time' });

  constructor(
    private readonly clock: Clock,
    private readonly trainFrameCount: number,
  ) {
    const button = (text: string, label: string, onclick: () => void): HTMLButtonElement =>
      h('button', { type: 'button', 'aria-label': label, title: label, onclick }, text);
    this.#play = h('button', { type: 'button', class: 'primary playback-play', onclick: () => this.toggle() }, 'Play');
    this.#slider = h('input', { type: 'range', min: 0, max: clock.frameCount - 1, step: 1, 'aria-label': 'Frame' });
    this.#slider.addEventListener('input', () => {
      clock.pause();
      clock.seek(this.#slider.valueAsNumber);
    });
    const speed = h('select', { 'aria-label': 'Speed' }, ...SPEEDS.map((value) =>
      h('option', { value, selected: value === clock.speed }, `${value} ×`)));
    speed.addEventListener('change', () => (clock.speed = Number(speed.value)));
    this.element = h('div', { class: 'playback-timeline' },
      h('div', { class: 'row' },
        this.#play,
        button('|◂', 'First frame', () => clock.step(-clock.frameCount)),
        button('◂', 'Frame before', () => clock.step(-1)),
        button('▸', 'Next frame', () => clock.step(1)),
        button('▸|', 'Last frame', () => clock.step(clock.frameCount)),
        speed,
        this.#output),
      this.#slider);
  }

  toggle(): void {
    if (this.clock.isPlaying) this.clock.pause();
    else this.clock.play();
  }

  /** Shows where the clock is. */
  show(): void {
    const { frame, frameCount, fps, isPlaying } = this.clock;
    this.#play.textContent = isPlaying ? 'Pause' : 'Play';
    const part = frame < this.trainFrameCount ? 'for fitting' : 'future';
    const text = `frame ${frame} of ${frameCount - 1}, ${(frame / fps).toFixed(2)} s, ${part}`;
    this.#output.textContent = text;
    this.#slider.value = String(frame);
    this.#slider.setAttribute('aria-valuetext', text);
  }
}

/** Keys of the page: Space plays, comma and full stop step. Keys of controls stay theirs. */
export function keyOf(event: KeyboardEvent): 'toggle' | 'back' | 'on' | null {
  if (event.ctrlKey || event.metaKey || event.altKey) return null;
  const target = event.target as HTMLElement | null;
  if (target?.closest('input:not([type="range"]), select, textarea, a, summary, dialog') != null) return null;
  if (event.key === ',') return 'back';
  if (event.key === '.') return 'on';
  if (event.key === ' ' && target?.closest('button, input') == null) return 'toggle';
  return null;
}
