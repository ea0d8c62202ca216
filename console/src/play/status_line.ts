import { h } from '../ui/dom';
import type { Stage } from '../view3d/stage';
import type { Facts } from './protocol/messages';
import type { PlayScene } from './scene';

/** Times that the shown one is the middle of. */
const MOST_TIMES = 60;

/** Facts of a play in a line: how fast it runs, is drawn, and follows what one does. */
export class StatusLine {
  readonly element = h('p', { class: 'play-facts' });
  readonly #times: number[] = [];
  #drawn = { count: 0, at: 0 };

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
    this.element.replaceChildren(...texts.filter((text) => text !== '').map((text) => h('span', {}, text)));
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
    this.element.replaceChildren();
  }
}
