import type { Api } from '../api/client';
import { token } from '../api/token';
import { h } from './dom';

/** Entries of the navigation: their text, and the first part of the addresses below them. */
const ENTRIES: readonly (readonly [string, string])[] = [
  ['Captures', 'captures'],
  ['Fits', 'fits'],
  ['Twins', 'twins'],
  ['Workers', 'workers'],
  ['Upload', 'upload'],
  ['Trash', 'trash'],
];

/** Frame around every page. */
export interface Frame {
  readonly heading: HTMLElement;
  /** Place of the page. */
  readonly place: HTMLElement;
  /** Said to people who use a screen reader. */
  readonly status: HTMLElement;
  /** Marks the entry of an address. */
  mark(path: string): void;
}

/** Puts navigation, heading and the place of pages into `app`; `logOut` is called by its button. */
export function frame(app: HTMLElement, api: Api, logOut: () => void): Frame {
  const status = h('div', { role: 'status', class: 'visually-hidden' });
  const heading = h('h1', { tabindex: '-1' });
  const place = h('div', { class: 'page' });
  const main = h('main', { id: 'main', tabindex: '-1' }, heading, place);
  const links = ENTRIES.map(([text, part]) => h('a', { href: `#/${part}` }, text));
  const leave = h('button', { type: 'button', class: 'small', onclick: logOut }, 'Log out');
  // A link by an address within the page would be taken for the address of another page.
  const skip = (event: Event): void => {
    event.preventDefault();
    main.focus();
  };
  app.replaceChildren(
    h('a', { class: 'skip', href: '#main', onclick: skip }, 'Skip to the content'),
    h(
      'header',
      { class: 'bar' },
      h('a', { class: 'home', href: '#/' }, 'BendTwin'),
      h('nav', { 'aria-label': 'Main' }, ...links),
      leave,
    ),
    lostBanner(api),
    main,
    status,
  );
  const mark = (path: string): void => {
    leave.hidden = token() === null;
    const first = path.split('/')[1] === 'plays' ? 'twins' : path.split('/')[1];
    ENTRIES.forEach(([, part], index) => {
      if (part === first) links[index]?.setAttribute('aria-current', 'page');
      else links[index]?.removeAttribute('aria-current');
    });
  };
  return { heading, place, status, mark };
}

/** Banner shown while the server does not answer. */
function lostBanner(api: Api): HTMLElement {
  const banner = h('div', { class: 'lost', role: 'status' });
  api.connection.addEventListener('lost', () => {
    banner.textContent = 'The server does not answer. Trying again…';
  });
  api.connection.addEventListener('back', () => (banner.textContent = ''));
  return banner;
}
