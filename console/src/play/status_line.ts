import { h } from '../ui/dom';
import type { Stage } from '../view3d/stage';
import type { Facts } from './protocol/messages';
import type { PlayScene } from './scene';

/** Times that the shown one is the middle of. */
const MOST_TIMES = 60;

/** Facts of a play in a line: how fast it runs, is drawn, and follows what one does. */
export class StatusLine {
  readonly element: HTMLElement;
  readonly #facts = h('p', { class: 'play-facts' });
  readonly #warning = h('p', { class: 'play-warning', hidden: true });
  readonly #times: number[] = [];
  #drawn = { count: 0, at: 0 };

  /** `announce` says something to people who use a screen reader. */
  constructor(private readonly announce: (text: string) => void) {
    this.element = h('div', { class: 'play-below' }, this.#warning, this.#facts);
  }

  /** Shows a warning, or none if it is empty; only the first of several in a row is announced. */
  warn(text: string): void {
    if (text === this.#warning.textContent) return;
    if (this.#warning.hidden && text !== '') this.announce(text);
    this.#warning.textContent = text;
    this.#warning.hidden = text === '';
  }

  /** Shows facts. */
  update(facts: Facts, scene: PlayScene): void {
    const now = performance.now();
    const drawn = (1000 * (scene.stage.drawn - this.#drawn.count)) / Math.max(now - this.#drawn.at, 1);
    this.#drawn = { count: scene.stage.drawn, at: now };
    const middle = [...this.#times].sort((a, b) => a - b)[this.#times.length >> 1];
    const texts = [
      `${facts.fps.toFixed(0)} frames/s simulated, ${facts.frame_ms.toFixed(1)} ms each`,
      `${drawn.toFixed(0)} pictures/s, ${scene.stage.drawMs.toFixed(1)} ms each`,
      facts.behind >= 1 ? `${facts.behind.toFixed(0)} frames behind` : '',
      facts.skipped > 0 ? `${facts.skipped} skipped` : '',
      facts.watchers > 0 ? `${facts.watchers} watching` : '',
      middle === undefined ? '' : `reaction ${middle.toFixed(0)} ms`,
      `strain up to ${(100 * (scene.state?.strain ?? 0)).toFixed(1)} %`,
    ];
    this.#facts.replaceChildren(...texts.filter((text) => text !== '').map((text) => h('span', {}, text)));
  }

  /** An input of a time [ms] has its first picture now. */
  acted(begun: number, stage: Stage): void {
    // The picture is drawn after this, in the same task.
    queueMicrotask(() => {
      const end = performance.now();
      const time = end - begun;
      this.#times.push(time);
      if (this.#times.length > MOST_TIMES) this.#times.shift();
      stage.canvas.dispatchEvent(new CustomEvent('bendtwin-acted', { detail: time }));
    });
  }

  /** Forgets what was measured. */
  clear(): void {
    this.#times.length = 0;
    this.#facts.replaceChildren();
    this.warn('');
  }
}
