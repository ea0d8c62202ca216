import { h } from '../ui/dom';
import { counted } from '../ui/format';
import { isolated } from '../pages/parts/text';
import { colourOf } from './drawing';
import { described } from './marking';
import type { Stroke, Strokes } from './strokes';

/** Strokes that are listed; of more only the last are. */
const MOST = 100;

/** The list of strokes; each can be shown and removed. */
export class StrokeList {
  readonly element = h('section', { class: 'masks-strokes', 'aria-labelledby': 'masks-marks' });
  readonly #heading = h('h2', { id: 'masks-marks', tabindex: '-1' });
  #shown: readonly Stroke[] | null = null;

  constructor(
    private readonly strokes: Strokes,
    private readonly cameras: readonly string[],
    /** Shows a stroke in its image. */
    private readonly reveal: (stroke: Stroke) => void,
  ) {}

  /** Shows the strokes, if they have changed. */
  show(): void {
    const { all } = this.strokes;
    if (all === this.#shown) return;
    this.#shown = all;
    const hadFocus = this.element.contains(document.activeElement);
    this.#heading.textContent = all.length === 0 ? 'Marks' : counted(all.length, 'mark');
    if (all.length === 0) {
      const text =
        'None yet. Choose a brush and click the object in one of the images, then the hand: ' +
        'one click per thing in one camera is enough, since depth carries it to the others.';
      this.element.replaceChildren(this.#heading, h('p', { class: 'muted' }, text));
    } else {
      const first = Math.max(all.length - MOST, 0);
      const rows = all.map((_, index) => index).slice(first).reverse();
      const clear = h('button', { type: 'button', class: 'small', onclick: () => this.strokes.clear() }, 'Remove all');
      this.element.replaceChildren(
        this.#heading,
        h('ul', { class: 'plain' }, ...rows.map((index) => this.#row(index))),
        first > 0 ? h('p', { class: 'hint' }, `${counted(first, 'earlier mark')} not listed`) : '',
        clear,
      );
    }
    // The button that had the focus may be gone.
    if (hadFocus) this.#heading.focus({ preventScroll: true });
  }

  #row(index: number): HTMLElement {
    const stroke = this.strokes.all[index]!;
    const text = described(stroke, isolated(this.cameras[stroke.camera] ?? String(stroke.camera)));
    const swatch = h('span', { class: `masks-swatch masks-swatch-${stroke.part}`, 'aria-hidden': 'true' });
    swatch.style.backgroundColor = colourOf(stroke.part);
    const button = (word: string, onclick: () => void): HTMLElement =>
      h('button', { type: 'button', class: 'small', 'aria-label': `${word}: ${text}`, onclick }, word);
    return h(
      'li',
      {},
      h('span', {}, swatch, text),
      button('Show', () => this.reveal(stroke)),
      button('Remove', () => this.strokes.remove(index)),
    );
  }
}
