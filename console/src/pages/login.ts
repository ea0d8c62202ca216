import { Problem } from '../api/client';
import { setToken } from '../api/token';
import type { OpenPage, PageContext } from '../page';
import { h } from '../ui/dom';
import { command } from '../ui/empty';
import { field } from '../ui/form';
import { problemBox } from '../ui/problem';

/** The page that asks for the token, and then leads back to where one was. */
export const open: OpenPage = (context) => {
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
    fault.replaceChildren(...(await faults(context, input.value.trim())));
    button.disabled = false;
    if (!context.signal.aborted) input.select();
  };
  const form = h(
    'form',
    { class: 'login', onsubmit: (event) => void submit(event) },
    h('p', {}, 'This server requires its token. The page keeps it until this tab is closed.'),
    field('Token', input, 'The token is in the file client-token in the data folder of the server. For the default folder:'),
    command('cat bendtwin-data/client-token'),
    fault,
    h('div', { class: 'buttons' }, button),
  );
  return { element: form };
};

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
