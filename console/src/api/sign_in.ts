import type { Api } from './client';

const KEY = 'bendtwin.sign-in';
/** Path to which the identity provider sends the browser back. */
const RETURN_PATH = '/sign-in';

/** A sign-in that this tab has begun; the server keeps nothing of it. */
interface Begun {
  readonly state: string;
  readonly nonce: string;
  readonly verifier: string;
  /** Address of the page that comes after it. */
  readonly next: string;
}

/** What the identity provider sent along. */
let returned: URLSearchParams | null = null;

/**
 * Takes what the identity provider has put into the address, so that neither the history nor a copied
 * link has it, and goes to the login page.
 */
export function takeReturnFromAddress(): void {
  if (location.pathname !== RETURN_PATH) return;
  returned = new URLSearchParams(location.search);
  history.replaceState(null, '', '/#/login');
}

/**
 * Address of the login page at the origin to which the identity provider sends browsers back, where the
 * sign-in has to begin; null at that origin. `next` stays behind the `#`, so it leads to no other site.
 */
export function loginElsewhere(publicUrl: string, next: string, here: string): string | null {
  if (!URL.canParse(publicUrl)) return null;
  const { protocol, origin } = new URL(publicUrl);
  if (!['https:', 'http:'].includes(protocol) || origin === here) return null;
  const query = next === '#/' ? '' : `?${new URLSearchParams({ next })}`;
  return `${origin}/#/login${query}`;
}

/** Begins a sign-in: the browser leaves for the identity provider. */
export async function beginSignIn(api: Api, next: string, signal: AbortSignal): Promise<void> {
  const begun: Begun = { state: random(), nonce: random(), verifier: random(), next };
  const hash = await crypto.subtle.digest('SHA-256', new TextEncoder().encode(begun.verifier));
  const challenge = { state: begun.state, nonce: begun.nonce, code_challenge: base64url(new Uint8Array(hash)) };
  const { authorization_url } = await api.send<{ authorization_url: string }>('POST', '/v1/sign-in/start', challenge, signal);
  sessionStorage.setItem(KEY, JSON.stringify(begun));
  location.assign(authorization_url);
}

/** True if the browser has come back from the identity provider. */
export function hasReturned(): boolean {
  return returned !== null;
}

/** Ends a sign-in, which can be done once. Returns the key and the page that comes next, or throws an error to show. */
export async function endSignIn(api: Api, signal: AbortSignal): Promise<{ key: string; next: string }> {
  const sent = returned ?? new URLSearchParams();
  const kept = sessionStorage.getItem(KEY);
  returned = null;
  sessionStorage.removeItem(KEY);
  const begun = kept === null ? null : (JSON.parse(kept) as Begun);
  if (begun === null || sent.get('state') !== begun.state) {
    throw new Error('This sign-in was not begun in this tab: begin again.');
  }
  const code = sent.get('code');
  if (code === null) {
    const said = sent.get('error_description') ?? sent.get('error') ?? 'it sent no code';
    throw new Error(`The identity provider refused: ${said.slice(0, 200)}`);
  }
  const proof = { code, code_verifier: begun.verifier, nonce: begun.nonce };
  const { secret_key } = await api.send<{ secret_key: string }>('POST', '/v1/sign-in', proof, signal);
  return { key: secret_key, next: begun.next };
}

/** Revokes the key of this tab at the server if it is that of a sign-in. */
export async function signOut(api: Api): Promise<void> {
  try {
    await api.fetch('/v1/sign-in', { method: 'DELETE', keepalive: true });
  } catch {
    // The key is forgotten here, and expires at the server.
  }
}

/** 256 random bits in base64url. */
function random(): string {
  return base64url(crypto.getRandomValues(new Uint8Array(32)));
}

/** Bytes in base64url without padding. */
function base64url(bytes: Uint8Array): string {
  return btoa(String.fromCharCode(...bytes)).replaceAll('+', '-').replaceAll('/', '_').replaceAll('=', '');
}
