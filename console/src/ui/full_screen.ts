import { h } from './dom';

/** A button that shows an element on the whole screen, and back; nothing where the browser has none. */
export function fullScreenButton(element: HTMLElement): HTMLElement | null {
  if (!document.fullscreenEnabled) return null;
  const button = h('button', { type: 'button', 'aria-pressed': 'false' }, 'Full screen');
  button.addEventListener('click', () => {
    const change = document.fullscreenElement === null ? element.requestFullscreen() : document.exitFullscreen();
    // A browser may refuse; then everything stays.
    change.catch(() => undefined);
  });
  const show = (): void => button.setAttribute('aria-pressed', String(document.fullscreenElement === element));
  // Escape ends it too.
  element.addEventListener('fullscreenchange', show);
  return button;
}
