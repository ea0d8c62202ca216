import { h, nodes } from './dom';
import type { Child } from './dom';

export interface Question {
  readonly title: string;
  readonly text: Child;
  /** Word of the button that agrees, as `Delete`. */
  readonly action: string;
  /** True if it cannot be undone. */
  readonly isDangerous?: boolean;
}

/** Asks before something is done; false if it was declined, also by Escape. */
export function confirm({ title, text, action, isDangerous = false }: Question): Promise<boolean> {
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
        h('button', { type: 'button', autofocus: true, onclick: end(false) }, 'Cancel'),
        h('button', { type: 'button', class: isDangerous ? 'danger' : 'primary', onclick: end(true) }, action),
      ),
    );
    dialog.addEventListener('close', () => {
      dialog.remove();
      resolve(agreed);
    });
    // A dialog does not outlive the page that asks.
    addEventListener('hashchange', () => dialog.close(), { once: true });
    document.body.append(dialog);
    dialog.showModal();
  });
}
