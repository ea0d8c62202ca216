import { copyButton } from './copy';
import { h } from './dom';
import type { Child } from './dom';

/** What a list that has no entries yet says. */
export interface Lesson {
  readonly title: string;
  /** What the entries are, in a sentence or two. */
  readonly text: Child;
  /** The one thing to do next: a link or a button. */
  readonly action: HTMLElement;
  /** How the same is done in a terminal. */
  readonly commands?: readonly string[];
}

/** An empty list that teaches what it is for, and leads to its first entry. */
export function lesson({ title, text, action, commands = [] }: Lesson): HTMLElement {
  return h(
    'div',
    { class: 'empty' },
    h('h2', {}, title),
    h('p', {}, text),
    h('div', { class: 'buttons' }, action),
    commands.length > 0 && [h('p', { class: 'muted' }, 'Or from a terminal:'), ...commands.map(command)],
  );
}

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
  return h('div', { class: 'command' }, h('code', {}, text), copyButton(text, `Copy: ${text}`));
}
