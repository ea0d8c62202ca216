import { Problem, ServerLost, sleep } from '@bendtwin/client';
import type { Api } from './api/client';
import { signOut } from './api/sign_in';
import { Tabs } from './api/tabs';
import { takeTokenFromAddress, token } from './api/token';
import { visitedTwin } from './api/visit';
import { load } from './load';
import './pages/shared/shared.css';
import type { Page, PageContext } from './page';
import { ROUTES, match } from './routes';
import { h } from './ui/dom';
import { frame } from './ui/frame';
import type { Frame } from './ui/frame';
import { problemBox } from './ui/problem';

const LOGIN = '/login';
/** Reason of a refusal once a sign-in has ended. */
const SIGN_IN_ENDED = 'SIGN_IN_ENDED';
const LISTS = ['captures', 'fits', 'twins'];
/** Time after which a page that is not there yet is announced [ms]. */
const QUICK_MS = 200;

/** Shows the page of the address in `app`, now and whenever the address changes. */
export function start(app: HTMLElement, api: Api): void {
  const tabs = new Tabs(goToLogin);
  const logOut = (): void => {
    void signOut(api);
    tabs.forget();
    goToLogin();
  };
  new Router(api, frame(app, api, logOut), tabs).start();
}

class Router {
  #page: Page | null = null;
  #left = new AbortController();
  /** True if the page could not be opened because the server did not answer. */
  #isWaiting = false;
  /** True while other tabs are asked for the token. */
  #isAsking = false;
  /** True once the server is known to answer without a token. */
  #isOpen = false;
  /** True once the page that is being opened has a title. */
  #hasTitle = false;

  constructor(
    private readonly api: Api,
    private readonly frame: Frame,
    private readonly tabs: Tabs,
  ) {}

  start(): void {
    addEventListener('hashchange', () => void this.show(true));
    this.api.onUnauthenticated = (problem) => {
      // The page of a visit says what has become of its link.
      if (visitedTwin() === null) void this.askForToken(problem.reason === SIGN_IN_ENDED);
    };
    this.api.connection.addEventListener('back', () => {
      if (this.#isWaiting) void this.show(false);
    });
    void this.show(false);
  }

  /** Opens the page of the address. */
  private async show(movesFocus: boolean): Promise<void> {
    takeTokenFromAddress();
    this.#left.abort();
    this.#page?.dispose?.();
    this.#page = null;
    this.#isWaiting = false;
    const { signal } = (this.#left = new AbortController());
    const { path, search } = address();
    const isVisit = visitedTwin() !== null;
    document.body.classList.toggle('is-visit', isVisit);
    if (!isVisit) this.frame.mark(path);
    this.frame.status.textContent = '';
    const found = match(ROUTES, path);
    if (found === null) {
      this.frame.place.removeAttribute('aria-busy');
      this.setTitle('Nothing here');
      this.frame.place.replaceChildren(h('p', {}, 'There is no page at this address.'));
      return;
    }
    const context = this.context(path, search, found.parameters, signal);
    this.#hasTitle = false;
    this.frame.place.setAttribute('aria-busy', 'true');
    void this.sayThatItLoads(signal);
    try {
      const open = await load(found.route, this.api);
      if (path !== LOGIN && !isVisit) await this.checkAccess(signal);
      if (signal.aborted) return;
      const opened = await open(context);
      if (signal.aborted) return opened.dispose?.();
      this.#page = opened;
      this.frame.place.replaceChildren(opened.element);
    } catch (error) {
      // Without a token one is on the way to the page that asks for it.
      if (signal.aborted || (error instanceof Problem && error.status === 401)) return;
      this.#isWaiting = error instanceof ServerLost;
      const isMissing = error instanceof Problem && error.status === 404;
      if (!this.#hasTitle) this.setTitle(isMissing ? 'Not found' : 'BendTwin');
      this.frame.place.replaceChildren(problemBox(error, () => void this.show(false)), wayOn(path));
    }
    this.frame.place.removeAttribute('aria-busy');
    if (movesFocus) this.frame.heading.focus();
  }

  /** Context of a page. A page that was left, but has not noticed yet, changes nothing of the next one. */
  private context(
    path: string,
    search: string,
    parameters: Readonly<Record<string, string>>,
    signal: AbortSignal,
  ): PageContext {
    const ifHere = (change: () => void): void => {
      if (!signal.aborted) change();
    };
    return {
      parameters,
      query: new URLSearchParams(search),
      api: this.api,
      signal,
      setTitle: (title) => ifHere(() => this.setTitle(title)),
      announce: (text) => ifHere(() => (this.frame.status.textContent = text)),
      navigate: (hash) => ifHere(() => (location.hash = hash)),
      setQuery: (query) =>
        ifHere(() => history.replaceState(null, '', `#${path}${query.size === 0 ? '' : `?${query}`}`)),
    };
  }

  /**
   * Throws what the server says to those who have no token, before a page is opened that asks for
   * nothing at first, or by a socket, which is refused without a word.
   */
  private async checkAccess(signal: AbortSignal): Promise<void> {
    if (token() !== null || this.#isOpen) return;
    await this.api.get('/v1/workers', { signal });
    this.#isOpen = true;
  }

  private setTitle(title: string): void {
    this.#hasTitle = true;
    this.frame.heading.replaceChildren(h('bdi', {}, title));
    document.title = title === 'BendTwin' ? title : `${title} - BendTwin`;
  }

  private async sayThatItLoads(signal: AbortSignal): Promise<void> {
    await sleep(QUICK_MS, signal);
    if (signal.aborted || !this.frame.place.hasAttribute('aria-busy')) return;
    this.frame.place.replaceChildren(h('p', { class: 'muted' }, 'Loading…'));
  }

  /** Takes the token of another tab, or goes to the page that asks for it, which leads back here. */
  private async askForToken(hasEnded: boolean): Promise<void> {
    if (address().path === LOGIN || this.#isAsking) return;
    this.#isAsking = true;
    const taken = await this.tabs.take();
    this.#isAsking = false;
    if (taken) return this.show(false);
    const here = location.hash;
    if (address().path === LOGIN) return;
    const query = new URLSearchParams();
    if (here !== '' && here !== '#/') query.set('next', here);
    if (hasEnded) query.set('ended', '');
    location.replace(`#${LOGIN}${query.size === 0 ? '' : `?${query}`}`);
  }
}

/** A link to the list that a page belongs to. */
function wayOn(path: string): HTMLElement | string {
  const list = LISTS.find((name) => path.startsWith(`/${name}/`));
  return list === undefined ? '' : h('p', {}, h('a', { href: `#/${list}` }, `All ${list}`));
}

function goToLogin(): void {
  // Who visits a twin was not logged in there.
  if (visitedTwin() === null) location.hash = `#${LOGIN}`;
}

/** Path and query of the address behind its `#`. */
function address(): { path: string; search: string } {
  const [path = '', search = ''] = location.hash.replace(/^#/, '').split('?', 2);
  return { path, search };
}
