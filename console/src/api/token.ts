const KEY = 'bendtwin.token';

/** The token that every request shows, or null if none was given. It lives as long as the tab. */
export function token(): string | null {
  return sessionStorage.getItem(KEY);
}

/** Keeps a token for this tab, or forgets it. */
export function setToken(value: string | null): void {
  if (value === null) sessionStorage.removeItem(KEY);
  else sessionStorage.setItem(KEY, value);
}

/**
 * Takes the token out of an address like `#/twins/1/play?token=…` and keeps it, so that neither
 * the history nor a copied link has it.
 */
export function takeTokenFromAddress(): void {
  const [path = '', search = ''] = location.hash.split('?', 2);
  const query = new URLSearchParams(search);
  const given = query.get('token');
  if (given === null) return;
  query.delete('token');
  setToken(given);
  const rest = query.toString();
  history.replaceState(null, '', `${location.pathname}${path}${rest === '' ? '' : `?${rest}`}`);
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
