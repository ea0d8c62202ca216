import { ServerLost } from '@bendtwin/client';
import type { Api } from './api/client';
import type { OpenPage } from './page';
import type { Route } from './routes';

const RELOADED = 'bendtwin.reloaded';
/** Time in which the console is not loaded a second time for lack of a file [ms]. */
const ONCE_IN_MS = 15_000;

/**
 * The page of a route, whose file may have to be fetched. If it cannot be, the server does not answer,
 * or it is a newer one with other files: once it answers, the console is reloaded, since browsers
 * do not fetch a module again that they did not get.
 */
export async function load(route: Route, api: Api): Promise<OpenPage> {
  try {
    return (await route.open()).open;
  } catch (error) {
    const last = Number(sessionStorage.getItem(RELOADED));
    if (Date.now() - last < ONCE_IN_MS) throw error;
    api.connection.addEventListener('back', reload, { once: true });
    api.connection.lost();
    throw new ServerLost();
  }
}

function reload(): void {
  sessionStorage.setItem(RELOADED, String(Date.now()));
  location.reload();
}
