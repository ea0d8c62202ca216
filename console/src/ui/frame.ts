import type { Api } from '../api/client';
import { token } from '../api/token';
import icon from '../icon.svg';
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
  const who = h('bdi', { class: 'who', hidden: true });
  const leave = h('button', { type: 'button', class: 'small quiet', onclick: logOut }, 'Log out');
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
      h('a', { class: 'home', href: '#/' }, h('img', { src: icon, alt: '' }), 'BendTwin'),
      h('nav', { 'aria-label': 'Main' }, ...links),
      h('div', { class: 'person' }, who, leave),
    ),
    lostBanner(api),
    main,
    status,
  );
  let shown: string | null = null;
  const mark = (path: string): void => {
    leave.hidden = token() === null;
    if (token() !== shown) {
      shown = token();
      who.hidden = true;
      void showPerson(api, who);
    }
    const first = path.split('/')[1] === 'plays' ? 'twins' : path.split('/')[1];
    ENTRIES.forEach(([, part], index) => {
      if (part === first) links[index]?.setAttribute('aria-current', 'page');
      else links[index]?.removeAttribute('aria-current');
    });
  };
  return { heading, place, status, mark };
}

/** Shows the name of the person who has signed in; a token or a key is nobody's. */
async function showPerson(api: Api, place: HTMLElement): Promise<void> {
  const asked = token();
  if (asked === null) return;
  try {
    const { owner, is_sign_in } = await api.get('/v1/caller', { signal: new AbortController().signal });
    if (!is_sign_in || token() !== asked) return;
    place.textContent = owner;
    place.title = owner;
    place.hidden = false;
  } catch {
    // The page that is opened shows what is wrong.
  }
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
