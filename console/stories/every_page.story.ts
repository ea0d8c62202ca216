import { beforeAll, describe, expect, it } from 'vitest';
import { Server } from '../scripts/server.mjs';
import { ROUTES, match } from '../src/routes';
import { call } from './kit/made';
import { fittedRope } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

/** Routes that need more than something stored: a play that is under way has its own story. */
const ELSEWHERE = ['/plays/:id'];

describe('every page', () => {
  withServer();
  let ids: Record<string, string[]>;
  beforeAll(async () => {
    for (const name of ['rope', 'another rope']) await fittedRope(server, name);
    const captures = await listed(server, 'captures');
    ids = { captures, fits: await listed(server, 'fits'), twins: await listed(server, 'twins') };
  });

  for (const { path } of ROUTES.filter((route) => !ELSEWHERE.includes(route.path))) {
    it(`${path} is for everyone, on screens of any size`, async () => {
      const at = address(path, ids);
      const name = path === '/' ? 'home' : path.slice(1).replaceAll('/', '-').replace(':id', 'one');
      const onLarge = async (): Promise<void> => {
        const large = await Visit.open(browser, server, { at });
        await settled(large, 1200);
        await large.stop(`page-${name}`);
        expect(await deadLinks(large), 'links that lead nowhere').toEqual([]);
        await large.close();
      };
      const onSmall = async (): Promise<void> => {
        const viewport = { width: 360, height: 740 };
        const small = await Visit.open(browser, server, { at, viewport, colorScheme: 'dark', reducedMotion: 'reduce' });
        await settled(small, 360);
        expect(await hiddenTables(small), 'tables that are wider than the screen').toEqual([]);
        await small.stop(`page-${name}-small`);
        await small.close();
      };
      // Much of the time of both is waiting for what a page asks for later.
      await Promise.all([onLarge(), onSmall()]);
    });
  }
});

/** The address of a route, with what is stored in the places of its parameters. */
function address(path: string, ids: Record<string, string[]>): string {
  const [, kind = ''] = path.split('/');
  const of = (wanted: string): string[] => ids[wanted] ?? [];
  if (path === '/fits/new') return `${path}?capture=${of('captures')[0]}`;
  if (path.endsWith('/compare')) return `${path}?ids=${of(kind).join(',')}`;
  return path.replace(':id', of(kind)[0] ?? '');
}

/** Waits until a page shows all that it has; it may not be wider than the screen. */
async function settled({ page }: Visit, width: number): Promise<void> {
  await page.locator('.page > *').first().waitFor();
  await page.waitForFunction(() => !document.querySelector('[aria-busy=true]'));
  await page.waitForLoadState('networkidle', { timeout: 3000 }).catch(() => undefined);
  expect(await page.locator('h1').allInnerTexts()).toEqual([expect.stringMatching(/\S/)]);
  // Places for messages may be there, but without one.
  const messages = await page.locator('main [role=alert]').allInnerTexts();
  expect(messages.filter((text) => text !== '')).toEqual([]);
  expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(width);
}

/** Addresses of the console that a page links to and that have no page. */
async function deadLinks({ page }: Visit): Promise<string[]> {
  const links = page.locator('a[href^="#/"]');
  const hrefs = await links.evaluateAll((found) => found.map((link) => link.getAttribute('href') ?? ''));
  return hrefs.filter((href) => match(ROUTES, href.slice(1).split('?')[0] ?? '') === null);
}

/** Tables that do not fit their place. Those in a fold that is closed have no size yet. */
async function hiddenTables({ page }: Visit): Promise<string[]> {
  return page.locator('.table-frame').evaluateAll((frames) =>
    frames
      .filter((frame) => frame.checkVisibility({ contentVisibilityAuto: true }) && frame.closest('details:not([open])') === null)
      .filter(({ scrollWidth, clientWidth }) => scrollWidth > clientWidth)
      .map((frame) => frame.getAttribute('aria-label') ?? ''),
  );
}

async function listed(server: Server, kind: string): Promise<string[]> {
  const page = await call<Record<string, { name: string }[]>>(server, 'GET', `/v1/${kind}`);
  return (page[kind] ?? []).map(({ name }) => name.slice(kind.length + 1));
}
