import { h } from './dom';
import type { Child } from './dom';

/** An empty list: what would be there, and the command that fills it. */
export function empty(text: Child, ...commands: string[]): HTMLElement {
  return h('div', { class: 'empty' }, h('p', {}, text), ...commands.map(command));
}

/** A command to be run in a terminal, with a button that copies it. */
export function command(text: string): HTMLElement {
  const button = h('button', { type: 'button', class: 'small', 'aria-label': `Copy: ${text}` }, 'Copy');
  button.addEventListener('click', () => {
    void navigator.clipboard.writeText(text).then(
      () => (button.textContent = 'Copied'),
      () => (button.textContent = 'Not copied'),
    );
  });
  // Browsers have a clipboard for pages of this machine and for those with TLS only.
  const canCopy = typeof navigator.clipboard?.writeText === 'function';
  return h('div', { class: 'command' }, h('code', {}, text), canCopy && button);
}
