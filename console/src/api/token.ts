import { keepVisitKey, visitedTwin, visitKey } from './visit';

const KEY = 'bendtwin.token';

/** The token that every request shows, or null if none was given: on the page of a visit its key. */
export function token(): string | null {
  return visitKey() ?? ownToken();
}

/** The token of the person in front of this tab. It lives as long as the tab. */
export function ownToken(): string | null {
  return sessionStorage.getItem(KEY);
}

/** Keeps a token for this tab, or forgets it. */
export function setToken(value: string | null): void {
  if (value === null) sessionStorage.removeItem(KEY);
  else sessionStorage.setItem(KEY, value);
}

/**
 * Takes the token out of an address like `#/twins/1/play?token=…`, or the key of a visit out of one like
 * `#/shared/1?key=…`, and keeps it, so that neither the history nor a copied link has it.
 */
export function takeTokenFromAddress(): void {
  const given = takeFromAddress('token');
  if (given !== null) setToken(given);
  const visited = visitedTwin();
  const key = visited === null ? null : takeFromAddress('key');
  if (visited !== null && key !== null) keepVisitKey(visited, key);
}

/** Takes a parameter out of the query behind the `#`; null if it is not there. */
function takeFromAddress(name: string): string | null {
  const [path = '', search = ''] = location.hash.split('?', 2);
  const query = new URLSearchParams(search);
  const given = query.get(name);
  if (given === null) return null;
  query.delete(name);
  const rest = query.toString();
  history.replaceState(null, '', `${location.pathname}${path}${rest === '' ? '' : `?${rest}`}`);
  return given;
}

/** The token in what was pasted: all of it, or that of an address such as `http://…/#/twins/1?token=…`. */
export function tokenIn(pasted: string): string {
  const text = pasted.trim();
  const [, given] = /^\S*[?&#]token=([^&#\s]+)/.exec(text) ?? [];
  if (given === undefined) return text;
  try {
    return decodeURIComponent(given);
  } catch {
    return given;
  }
}
