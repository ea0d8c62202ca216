import { h } from './dom';
import type { Child } from './dom';

/** An empty list: what would be there, and the command that fills it. */
export function empty(text: Child, ...commands: string[]): HTMLElement {
  return h('div', { class: 'empty' }, h('p', {}, text), ...commands.map(command));
}

/** The default port of clients. */
const DEFAULT_PORT = '7070';

/** A command of the command line for this server: its address is in it unless it is the default. */
export function cli(text: string): string {
  const { origin, hostname, port, protocol } = location;
  const isDefault = protocol === 'http:' && port === DEFAULT_PORT && ['127.0.0.1', 'localhost'].includes(hostname);
  return isDefault ? text : `${text} --server ${origin}`;
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
