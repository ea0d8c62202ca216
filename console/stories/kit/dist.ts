import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import type { BrowserContext } from 'playwright-core';

const DIST = fileURLToPath(new URL('../../dist/', import.meta.url));

/**
 * Replaces the files that a server has embedded by those of `npm run build`, under the server's headers, so that
 * stories run on changed sources without building the server again.
 */
export async function serveDist(context: BrowserContext, url: string): Promise<void> {
  // Chromium takes what a story answers for a page of the internet, which asks before it connects to this machine.
  await context.grantPermissions(['local-network-access'], { origin: url });
  const { headers } = await fetch(url);
  const policy = headers.get('content-security-policy') ?? '';
  await context.route(
    (address) => address.origin === url && /^\/($|sign-in$|assets\/)/.test(address.pathname),
    (route) => {
      const { pathname } = new URL(route.request().url());
      const path = join(DIST, pathname.startsWith('/assets/') ? pathname : 'index.html');
      // A page that another site leads to comes from the server itself, and asks for the server's files.
      if (!existsSync(path)) return route.fallback();
      return route.fulfill({ path, headers: { 'content-security-policy': policy } });
    },
  );
}
