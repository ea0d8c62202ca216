import type { Api } from './api/client';

/** Context in which a page is opened. */
export interface PageContext {
  /** Parts of the address that the route names, as `id` in `#/twins/:id`. */
  readonly parameters: Readonly<Record<string, string>>;
  /** The query behind the route, as in `#/twins/1?frame=12`. */
  readonly query: URLSearchParams;
  readonly api: Api;
  /** Aborted when the page is left: every request of the page is made with it. */
  readonly signal: AbortSignal;
  /** Names the page, in the heading and in the title of the window. */
  setTitle(title: string): void;
  /** Says something to people who use a screen reader. */
  announce(text: string): void;
  /** Goes to another page, as `#/fits/1`. */
  navigate(hash: string): void;
  /** Replaces the query of the page's address without opening the page again, for links to a moment. */
  setQuery(query: URLSearchParams): void;
}

/** A page that is shown. */
export interface Page {
  readonly element: HTMLElement;
  /** Releases what the page holds: sockets, timers, the GPU's memory. */
  dispose?(): void;
}

/** Opens a page; what it throws is shown in its place. */
export type OpenPage = (context: PageContext) => Page | Promise<Page>;
