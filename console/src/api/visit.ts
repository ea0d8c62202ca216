/**
 * Visits: pages below `#/shared/{id}`, which people open by a link to one twin. The link contains a key for
 * that twin, which counts on its page alone: it takes the place of nobody's token, and other tabs do not
 * hear of it.
 */
const KEY = 'bendtwin.shared.';

/** The twin of a visit, as the address names it; null on all other pages. */
export function visitedTwin(): string | null {
  // Outside of pages, as in tests, there is no address.
  return /^#\/shared\/([^/?]+)/.exec(globalThis.location?.hash ?? '')?.[1] ?? null;
}

/** The key of the visit; null on other pages, and on a server that requires none. */
export function visitKey(): string | null {
  const twin = visitedTwin();
  return twin === null ? null : sessionStorage.getItem(KEY + twin);
}

/** Keeps a key for the visits of this tab to a twin. */
export function keepVisitKey(twin: string, key: string): void {
  sessionStorage.setItem(KEY + twin, key);
}

/** The address of a visit to a twin: with the key, or without one where the server requires none. */
export function visitAddress(twin: string, key: string | null, moment = new URLSearchParams()): string {
  const query = new URLSearchParams(moment);
  if (key !== null) query.set('key', key);
  return `${location.origin}${location.pathname}#/shared/${twin}${query.size === 0 ? '' : `?${query}`}`;
}

let allowed = false;

/** Notes whether the link of the visit allows downloads of the twin. */
export function allowDownload(allows: boolean): void {
  allowed = allows;
}

/** True if the twin's file may be read: always, but for visits whose link does not allow it. */
export function mayDownload(): boolean {
  return visitedTwin() === null || allowed;
}
