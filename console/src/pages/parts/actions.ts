import { token } from '../../api/token';
import type { PageContext } from '../../page';
import { confirm, type Question } from '../../ui/dialog';
import { h, type Child } from '../../ui/dom';
import { problemBox } from '../../ui/problem';

/** A place below buttons for what went wrong with them. */
export function faultPlace(): HTMLElement {
  return h('div', { class: 'fault-place' });
}

/** A button that does something once, and shows what went wrong in `faults`. */
export function actionButton(
  context: PageContext,
  text: string,
  faults: HTMLElement,
  act: () => Promise<void>,
  className: string | null = null,
): HTMLButtonElement {
  const run = async (): Promise<void> => {
    button.disabled = true;
    button.setAttribute('aria-busy', 'true');
    faults.replaceChildren();
    try {
      await act();
    } catch (error) {
      if (!context.signal.aborted) faults.replaceChildren(problemBox(error));
    }
    button.removeAttribute('aria-busy');
    button.disabled = false;
  };
  const button = h('button', { type: 'button', class: className, onclick: () => void run() }, text);
  return button;
}

/** Words of a question before something is deleted. */
type Words = Pick<Question, 'title' | 'text'>;

/** A button that moves a resource to the trash after a question, which may have to be asked for, and then goes to `next`. */
export function deleteButton(
  context: PageContext,
  path: string,
  question: Words | (() => Promise<Words>),
  next: string,
  faults: HTMLElement,
): HTMLElement {
  const remove = async (): Promise<void> => {
    const words = typeof question === 'function' ? await question() : question;
    if (!(await confirm({ ...words, action: 'Delete', isDangerous: true }))) return;
    await context.api.fetch(path, { method: 'DELETE', signal: context.signal });
    context.announce('Moved to the trash');
    context.navigate(next);
  };
  return actionButton(context, 'Delete', faults, remove, 'danger');
}

/**
 * A link that downloads a file of the API. Where a token is asked for, a link cannot show it: the
 * file is fetched and handed to the browser then.
 */
export function download(
  context: PageContext,
  text: Child,
  path: string,
  fileName: string,
  faults: HTMLElement,
): HTMLElement {
  if (token() === null) return h('a', { class: 'button', href: path, download: fileName }, text);
  const fetchFile = async (): Promise<void> => {
    const answer = await context.api.fetch(path, { signal: context.signal });
    saveBlob(await answer.blob(), fileName);
  };
  const button = actionButton(context, '', faults, fetchFile);
  button.append(...(typeof text === 'string' || text instanceof Node ? [text] : []));
  return button;
}

/** Hands bytes to the browser's downloads. */
function saveBlob(blob: Blob, fileName: string): void {
  const address = URL.createObjectURL(blob);
  h('a', { href: address, download: fileName }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
