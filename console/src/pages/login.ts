import { Problem, type SignIn } from '@bendtwin/client';
import { beginSignIn, endSignIn, hasReturned, loginElsewhere } from '../api/sign_in';
import { setToken, tokenIn } from '../api/token';
import type { OpenPage, PageContext } from '../page';
import { h } from '../ui/dom';
import { command } from '../ui/empty';
import { field } from '../ui/form';
import { problemBox } from '../ui/problem';

/** The page that lets people sign in, or asks for the token, and then leads back to where one was. */
export const open: OpenPage = async (context) => {
  context.setTitle('Log in');
  const input = h('input', {
    type: 'password',
    name: 'token',
    autocomplete: 'current-password',
    spellcheck: 'false',
    required: true,
  });
  const fault = h('div');
  const button = h('button', { type: 'submit', class: 'primary' }, 'Log in');
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    button.disabled = true;
    fault.replaceChildren(...(await faults(context, tokenIn(input.value))));
    button.disabled = false;
    if (!context.signal.aborted) input.select();
  };
  const form = h(
    'form',
    { class: 'login', onsubmit: (event) => void submit(event) },
    h('p', {}, 'This server requires its token or a key. The page keeps it until this tab is closed.'),
    field('Token', input, 'The token itself, or an address that contains it, such as the one that bendtwin demo prints.'),
    fault,
    h('div', { class: 'buttons' }, button),
    h('h2', {}, 'Where is the token?'),
    h(
      'p',
      {},
      'On the machine of the server, in the file ',
      h('code', {}, 'client-token'),
      ' of its data folder. For the default folder:',
    ),
    command('cat bendtwin-data/client-token'),
    h('p', { class: 'hint' }, "If the server is somebody else's, ask them for a key."),
  );
  const signIn = await signInOptions(context);
  if (signIn === null && !hasReturned()) return { element: form };
  const place = h('div', { class: 'login' });
  if (hasReturned()) void endHere(context, place, signIn);
  else if (signIn !== null) offer(context, place, signIn);
  // People sign in; the token is for those who run the server.
  const other = h('details', {}, h('summary', {}, 'Log in with the token or a key'), form);
  return { element: h('div', {}, place, other) };
};

/** What the server says about its identity provider; null if it has none. */
async function signInOptions({ api, signal }: PageContext): Promise<SignIn | null> {
  try {
    const options = await api.get('/v1/sign-in', { signal });
    return options.enabled ? options : null;
  } catch {
    // The token still lets people in; the banner says if the server does not answer.
    return null;
  }
}

/** Shows the button of the identity provider. */
function offer(context: PageContext, place: HTMLElement, { display_name, public_url }: SignIn): void {
  const { api, signal } = context;
  const after = next(context.query);
  const elsewhere = loginElsewhere(public_url ?? '', after, location.origin);
  const ended = context.query.get('ended') !== null;
  const fault = h('div');
  const button = h('button', { type: 'button', class: 'primary' }, 'Sign in with ', h('bdi', {}, display_name ?? ''));
  const go = async (): Promise<void> => {
    if (elsewhere === null) await beginSignIn(api, after, signal);
    else location.assign(elsewhere);
  };
  button.addEventListener('click', () => void leave(button, fault, go, signal));
  place.append(
    ended ? h('p', { role: 'status' }, 'Your sign-in has ended. Sign in again.') : '',
    elsewhere === null ? '' : h('p', {}, 'Sign-in is at another address of this server: ', new URL(elsewhere).origin),
    h('div', { class: 'buttons' }, button),
    fault,
  );
}

/** Does what leaves the page, and shows why that failed. */
async function leave(button: HTMLButtonElement, fault: HTMLElement, doing: () => Promise<void>, signal: AbortSignal): Promise<void> {
  button.disabled = true;
  try {
    await doing();
  } catch (error) {
    if (!signal.aborted) fault.replaceChildren(problemBox(error));
    button.disabled = false;
  }
}

/** Ends the sign-in from which the browser has come back. */
async function endHere(context: PageContext, place: HTMLElement, options: SignIn | null): Promise<void> {
  const { api, signal } = context;
  place.replaceChildren(h('p', { role: 'status' }, 'Signing in…'));
  try {
    const { key, next } = await endSignIn(api, signal);
    setToken(key);
    context.navigate(next);
  } catch (error) {
    if (signal.aborted) return;
    place.replaceChildren(problemBox(error));
    if (options !== null) offer(context, place, options);
  }
}

/** Tries a token and continues with it; otherwise returns the box that shows the fault. */
async function faults(context: PageContext, shown: string): Promise<HTMLElement[]> {
  // Headers carry no other characters, and no token has any.
  if (!/^[\x21-\x7e]+$/.test(shown)) return [wrong()];
  setToken(shown);
  try {
    await context.api.get('/v1/workers', { signal: context.signal });
    context.navigate(next(context.query));
    return [];
  } catch (error) {
    // What is known but may not see workers is no wrong one.
    if (error instanceof Problem && error.status === 403) {
      context.navigate(next(context.query));
      return [];
    }
    setToken(null);
    if (context.signal.aborted) return [];
    const isWrong = error instanceof Problem && error.status === 401;
    return [isWrong ? wrong() : problemBox(error)];
  }
}

function wrong(): HTMLElement {
  return h('p', { class: 'problem', role: 'alert' }, 'This is not the token of this server.');
}

/** Address of the page that asked; only those of the console count. */
function next(query: URLSearchParams): string {
  const wanted = query.get('next') ?? '';
  return wanted.startsWith('#/') && !wanted.startsWith('#/login') ? wanted : '#/';
}
