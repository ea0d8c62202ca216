import { h, nodes } from './dom';
import type { Child } from './dom';

export interface Question {
  readonly title: string;
  readonly text: Child;
  /** Word of the button that agrees, as `Delete`. */
  readonly action: string;
  /** Word of the button that declines; default: `Cancel`. */
  readonly decline?: string;
  /** True if it cannot be undone. */
  readonly isDangerous?: boolean;
}

/** Shows something over the page until it is closed. */
export function showDialog(title: string, ...content: Child[]): void {
  const close = (): void => dialog.close();
  const dialog = h(
    'dialog',
    { 'aria-labelledby': 'dialog-title', class: 'dialog dialog-large' },
    h('h2', { id: 'dialog-title' }, title),
    ...content,
    h('div', { class: 'buttons' }, h('button', { type: 'button', autofocus: true, onclick: close }, 'Close')),
  );
  open(dialog);
}

/** Opens a dialog, which is removed when it is closed, and does not outlive its page. */
function open(dialog: HTMLDialogElement): void {
  dialog.addEventListener('close', () => dialog.remove());
  addEventListener('hashchange', () => dialog.close(), { once: true });
  document.body.append(dialog);
  dialog.showModal();
}

/** Asks before something is done; false if it was declined, also by Escape. */
export function confirm({ title, text, action, decline = 'Cancel', isDangerous = false }: Question): Promise<boolean> {
  return new Promise((resolve) => {
    let agreed = false;
    const end = (agrees: boolean) => (): void => {
      agreed = agrees;
      dialog.close();
    };
    const dialog = h(
      'dialog',
      { 'aria-labelledby': 'dialog-title', class: 'dialog' },
      h('h2', { id: 'dialog-title' }, title),
      h('div', {}, ...nodes([text])),
      h(
        'div',
        { class: 'buttons' },
        h('button', { type: 'button', autofocus: true, onclick: end(false) }, decline),
        h('button', { type: 'button', class: isDangerous ? 'danger' : 'primary', onclick: end(true) }, action),
      ),
    );
    dialog.addEventListener('close', () => resolve(agreed));
    open(dialog);
  });
}
