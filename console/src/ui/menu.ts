import { h, type Child } from './dom';

let menus = 0;

/** How a menu's button looks. */
export interface MenuOptions {
  /** Class of the button, as `primary`. */
  readonly class?: string;
  /** Name for screen readers, if the text is not enough. */
  readonly label?: string;
}

/**
 * A button with a list of links and buttons that opens below it. Arrow keys go through the list; Escape, a click
 * elsewhere, and leaving the list close it.
 */
export function menu(text: Child, items: readonly HTMLElement[], options: MenuOptions = {}): HTMLElement {
  menus += 1;
  const list = h('ul', { class: 'menu-list', id: `menu-${menus}`, hidden: true }, ...items.map((item) => h('li', {}, item)));
  const button = h(
    'button',
    { type: 'button', class: options.class, 'aria-label': options.label, 'aria-expanded': 'false', 'aria-controls': list.id },
    text,
    h('span', { class: 'menu-arrow', 'aria-hidden': 'true' }),
  );
  const element = h('div', { class: 'menu' }, button, list);
  const outside = (event: Event): void => {
    if (!element.contains(event.target as Node)) show(false);
  };
  const show = (isOpen: boolean): void => {
    list.hidden = !isOpen;
    button.setAttribute('aria-expanded', String(isOpen));
    removeEventListener('pointerdown', outside);
    if (!isOpen) return;
    addEventListener('pointerdown', outside);
    list.classList.remove('at-end');
    list.classList.toggle('at-end', list.getBoundingClientRect().right > document.documentElement.clientWidth);
  };
  button.addEventListener('click', () => show(list.hidden));
  list.addEventListener('click', (event) => {
    if ((event.target as Element).closest('a') !== null) show(false);
  });
  element.addEventListener('focusout', ({ relatedTarget }) => {
    const isLeft = relatedTarget instanceof Element && !element.contains(relatedTarget);
    // A question of an item takes the focus for a while.
    if (isLeft && relatedTarget.closest('dialog') === null) show(false);
  });
  element.addEventListener('keydown', (event) => {
    if (event.key === 'Escape' && !list.hidden) {
      show(false);
      button.focus();
    } else if (event.key === 'ArrowDown' || event.key === 'ArrowUp') {
      event.preventDefault();
      if (list.hidden) show(true);
      step(list, event.key === 'ArrowDown' ? 1 : -1);
    }
  });
  return element;
}

/** Moves the focus to the next item of a list, or the one before; from the last to the first. */
function step(list: HTMLElement, by: number): void {
  const items = [...list.querySelectorAll<HTMLElement>('a, button')];
  const at = items.findIndex((item) => item === document.activeElement);
  items[at < 0 ? (by > 0 ? 0 : items.length - 1) : (at + by + items.length) % items.length]?.focus();
}
