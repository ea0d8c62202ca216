import { describe, expect, it } from 'vitest';
import { BUILT, EMBED, MOST_BYTES, read } from '../scripts/built.mjs';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

const ENTRIES = ['Captures', 'Fits', 'Twins', 'Workers', 'Upload'];

describe('the frame of all pages', () => {
  withServer();

  it('can be used with the keyboard alone', async () => {
    const visit = await Visit.open(browser, server);
    await visit.heading('BendTwin');
    const { keyboard } = visit.page;
    const focused = (): Promise<string> => visit.page.evaluate(() => document.activeElement?.textContent ?? '');
    await keyboard.press('Tab');
    expect(await focused()).toBe('Skip to the content');
    await visit.stop('skip-link');
    await keyboard.press('Enter');
    expect(await visit.page.evaluate(() => document.activeElement?.id)).toBe('main');
    await visit.page.reload();
    await visit.heading('BendTwin');
    for (const entry of ['Skip to the content', 'BendTwin', ...ENTRIES]) {
      await keyboard.press('Tab');
      expect(await focused()).toBe(entry);
      expect(await outline(visit), `the focus on ${entry} can be seen`).not.toBe('none');
    }
    // To the page of an entry; the focus goes along, and the entry is marked.
    await keyboard.press('Shift+Tab');
    await keyboard.press('Enter');
    await visit.heading('Workers');
    await expect.poll(focused).toBe('Workers');
    expect(await visit.page.locator('nav [aria-current=page]').textContent()).toBe('Workers');
    await visit.stop('workers');
    await visit.page.goBack();
    await visit.heading('BendTwin');
    await visit.close();
  });

  it('fits a small screen, in the dark and in the light', async () => {
    for (const colorScheme of ['dark', 'light'] as const) {
      const viewport = { width: 360, height: 740 };
      const visit = await Visit.open(browser, server, { viewport, colorScheme });
      for (const [at, heading] of [['/', 'BendTwin'], ['/workers', 'Workers'], ['/login', 'Log in']] as const) {
        await visit.go(at);
        await visit.heading(heading);
        await visit.page.waitForFunction(() => !document.querySelector('main [aria-busy=true]'));
        expect(await visit.page.evaluate(() => document.documentElement.scrollWidth), at).toBeLessThanOrEqual(360);
        await visit.stop(`small-${colorScheme}-${heading.toLowerCase().replace(' ', '-')}`);
      }
      await visit.close();
    }
  });

  it('shows the page that was asked for last, however late another one comes', async () => {
    const visit = await Visit.open(browser, server);
    await visit.heading('BendTwin');
    let letGo = (): void => {};
    const held = new Promise<void>((resolve) => (letGo = resolve));
    const asked = visit.page.waitForRequest(/\/assets\/page-.*\.js/);
    await visit.page.route(/\/assets\/page-/, async (route) => {
      await held;
      await route.fallback();
    });
    await visit.go('/upload');
    const late = (await asked).url();
    await visit.page.getByText('Loading…').waitFor();
    await visit.go('/workers');
    await visit.heading('Workers');
    const come = visit.page.waitForResponse(late);
    letGo();
    await (await come).finished();
    await visit.page.evaluate(() => new Promise(requestAnimationFrame));
    await visit.heading('Workers');
    expect(await visit.page.title()).toBe('Workers - BendTwin');
    await visit.close();
  });

  it('shows why a page cannot be opened', async () => {
    const visit = await Visit.open(browser, server);
    visit.allow(/404/);
    await visit.go('/twins/01999999-9999-7999-8999-999999999999');
    await visit.heading('Not found');
    // Longer than it takes a page to say that it loads.
    await visit.page.waitForTimeout(400);
    expect(await visit.page.getByRole('alert').innerText()).not.toBe('');
    await visit.page.getByRole('link', { name: 'All twins' }).click();
    await visit.heading('Twins');
    await visit.close();
  });

  it('says what to do when nothing is there', async () => {
    const visit = await Visit.open(browser, server);
    await visit.page.getByRole('link', { name: 'Upload a recording' }).waitFor();
    await visit.page.getByText('bendtwin capture push rope.zip').waitFor();
    await visit.stop('home-empty');
    await visit.close();
  });

  it('is light, and there at once', async () => {
    const files = [...read(BUILT)].filter(([name]) => name.endsWith('.gz') && name !== `${EMBED}.gz`);
    const bytes = files.reduce((sum, [, content]) => sum + content.length, 0);
    expect(bytes).toBeLessThanOrEqual(MOST_BYTES);
    const visit = await Visit.open(browser, server);
    await visit.heading('BendTwin');
    // The browser tells of a paint some time after it.
    const told = await visit.page.waitForFunction(() => performance.getEntriesByName('first-contentful-paint')[0]);
    const paint = await told.evaluate((entry) => entry?.startTime ?? 0);
    const loaded = await visit.page.evaluate(() =>
      performance
        .getEntriesByType('resource')
        .filter((entry) => new URL(entry.name).pathname.startsWith('/assets/'))
        .reduce((sum, entry) => sum + (entry as PerformanceResourceTiming).transferSize, 0),
    );
    console.log(`first paint after ${Math.round(paint)} ms, ${loaded} bytes loaded of ${bytes} in all`);
    // The first page loads no three-dimensional view.
    expect(loaded).toBeLessThan(40_000);
    await visit.close();
  });
});

function outline(visit: Visit): Promise<string> {
  return visit.page.evaluate(() => getComputedStyle(document.activeElement ?? document.body).outlineStyle);
}
