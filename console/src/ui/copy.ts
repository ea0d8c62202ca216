import { h } from './dom';

/** A button that copies a text; null where the browser has no clipboard, which needs TLS or this machine. */
export function copyButton(text: string, label: string): HTMLButtonElement | null {
  if (typeof navigator.clipboard?.writeText !== 'function') return null;
  const button = h('button', { type: 'button', class: 'small', 'aria-label': label }, 'Copy');
  button.addEventListener('click', () => {
    void navigator.clipboard.writeText(text).then(
      () => (button.textContent = 'Copied'),
      () => (button.textContent = 'Not copied'),
    );
  });
  return button;
}

/** Lines of a program, with a button that copies them. */
export function snippet(text: string, label: string): HTMLElement {
  return h(
    'div',
    { class: 'snippet' },
    h('pre', { tabindex: '0', role: 'region', 'aria-label': label }, h('code', {}, text)),
    copyButton(text, `Copy: ${label}`),
  );
}
