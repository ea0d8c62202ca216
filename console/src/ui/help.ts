import { h } from './dom';

/** Distance of an explanation from its button and from the edges of the window [pixels]. */
const MARGIN = 8;

let helps = 0;

/** A `?` that explains a term. The explanation opens below it; Escape and a click elsewhere close it. */
export function help(term: string, text: string): HTMLElement {
  helps += 1;
  const panel = h('span', { class: 'help-text', id: `help-${helps}`, popover: 'auto' }, text);
  const button = h('button', { type: 'button', class: 'help', 'aria-label': `Explain: ${term}`, popovertarget: panel.id }, '?');
  panel.addEventListener('toggle', () => place(panel, button));
  return h('span', { class: 'help-place' }, button, panel);
}

/** Puts an explanation below its button, within the window. */
function place(panel: HTMLElement, button: HTMLElement): void {
  const { left, bottom } = button.getBoundingClientRect();
  const most = document.documentElement.clientWidth - panel.offsetWidth - MARGIN;
  panel.style.left = `${Math.max(Math.min(left, most), MARGIN)}px`;
  panel.style.top = `${bottom + MARGIN}px`;
}
