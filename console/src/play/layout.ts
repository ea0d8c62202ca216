import { h } from '../ui/dom';
import { fullScreenButton } from '../ui/full_screen';
import { button } from './panels/parts';

/** Parts of a page of a twin in three dimensions. */
export interface Parts {
  /** Controls above the picture. */
  readonly bar: HTMLElement;
  readonly stage: HTMLElement;
  /** Facts below the picture. */
  readonly below: HTMLElement;
  readonly panels: readonly HTMLElement[];
}

/** A page whose picture takes all the room there is, with panels that fold away, and the whole screen if one wants. */
export function layoutOf({ bar, stage, below, panels }: Parts): HTMLElement {
  const root = h('div', { class: 'play wide' });
  const fold = button('Hide panels', () => {
    const isFolded = root.classList.toggle('is-folded');
    fold.textContent = isFolded ? 'Show panels' : 'Hide panels';
    fold.setAttribute('aria-expanded', String(!isFolded));
  }, { class: 'play-fold', 'aria-expanded': 'true', 'aria-controls': 'play-panels' });
  root.append(
    h('div', { class: 'play-main' },
      h('div', { class: 'row play-bar' }, bar, h('div', { class: 'row' }, fullScreenButton(root), fold)),
      stage, below),
    h('div', { class: 'play-panels', id: 'play-panels' }, ...panels));
  return root;
}
