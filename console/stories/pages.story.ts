import { rmSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { call, folder, makeCapture, sendCapture, until } from './kit/made';
import { COARSE } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

const NAME = '<img src=x onerror="document.title=1">\u202E"><script>document.title=2</script>';
const NOTE = `</p><svg onload=document.title=3> ${'wide'.repeat(400)}\n\`code\` javascript:alert(1)`;

describe('the pages of captures, fits and twins', () => {
  withServer();
  const files = folder();
  /** Addresses of all of them. */
  let addresses: string[] = [];
  beforeAll(async () => {
    const capture = await sendCapture(server, makeCapture(join(files, 'rope.zip'), 'rope'), NAME);
    const settings = { effort: 'draft', ...COARSE };
    for (const seed of [1, 2]) await call(server, 'POST', '/v1/fits', { capture, settings: { ...settings, seed } });
    const broken = await call<{ name: string }>(
      server,
      'POST',
      `/v1/captures?${new URLSearchParams({ display_name: NAME })}`,
      Buffer.from('<b>no archive'),
    );
    await until(async () => (await list('twins')).length === 2);
    const [fits, twins] = [await list('fits'), await list('twins')];
    for (const name of [capture, ...fits, ...twins])
      await call(server, 'PATCH', `/v1/${name}`, { note: NOTE, tags: ['wet'] });
    const ids = (names: readonly string[]): string => names.map((name) => name.split('/')[1]).join(',');
    addresses = [
      '/captures',
      `/${capture}`,
      `/${broken.name}`,
      '/fits',
      `/fits/new?capture=${capture.split('/')[1]}`,
      `/${fits[0]}`,
      `/fits/compare?ids=${ids(fits)}`,
      '/twins',
      `/${twins[0]}`,
      `/twins/compare?ids=${ids(twins)}`,
      '/upload',
    ];
  });
  afterAll(async () => {
    rmSync(files, { recursive: true });
  });

  /** Names of all resources of a kind. */
  async function list(kind: 'fits' | 'twins'): Promise<string[]> {
    const found = await call<Record<string, { name: string }[]>>(server, 'GET', `/v1/${kind}`);
    return (found[kind] ?? []).map(({ name }) => name);
  }

  /** A page at rest, at each address. */
  async function eachPage(visit: Visit, look: (at: string) => Promise<void>): Promise<void> {
    for (const at of addresses) {
      await visit.go(at);
      await visit.page.waitForLoadState('networkidle');
      await visit.page.waitForFunction(() => !document.querySelector('main [aria-busy=true]'));
      await look(at);
    }
  }

  it('show hostile names and notes as the texts that they are', async () => {
    const visit = await Visit.open(browser, server);
    await eachPage(visit, async (at) => {
      expect(await visit.page.locator('main img[src=x], main svg, main script, main b').count(), at).toBe(0);
      expect(await visit.page.title(), at).toMatch(/ - BendTwin$/);
      expect(await visit.page.title(), at).not.toMatch(/^\d/);
    });
    await visit.go(addresses[1] ?? '');
    await visit.page.getByRole('heading', { level: 1 }).getByText(NAME).waitFor();
    await visit.stop('hostile-capture');
    await visit.go(addresses[2] ?? '');
    await visit.page.getByText('This capture cannot be fitted').waitFor();
    await visit.stop('capture-broken');
    await visit.close();
  });

  it('fit a small screen, in the dark and in the light, and keep nobody out', async () => {
    const small = async (colorScheme: 'light' | 'dark'): Promise<void> => {
      const visit = await Visit.open(browser, server, { viewport: { width: 360, height: 740 }, colorScheme });
      await eachPage(visit, async (at) => {
        expect(await visit.page.evaluate(() => document.documentElement.scrollWidth), at).toBeLessThanOrEqual(360);
        await visit.stop(
          `small-${colorScheme}${at
            .replace(/\?.*/, '')
            .replace(/[0-9a-f-]{36}/, 'one')
            .replaceAll('/', '-')}`,
        );
      });
      await visit.close();
    };
    await Promise.all([small('light'), small('dark')]);
  });

  it('can be used with the keyboard alone', async () => {
    const visit = await Visit.open(browser, server, { at: '/captures' });
    const { page } = visit;
    const { keyboard } = page;
    await page.getByRole('link', { name: /^Fit / }).first().waitFor();
    await tabTo(visit, /^Search in names/);
    await keyboard.type('onerror');
    await expect.poll(() => new URL(page.url()).hash).toContain('search=onerror');
    await tabTo(visit, /^Fit /);
    await keyboard.press('Enter');
    await visit.heading('Start a fit');
    await page.getByRole('button', { name: 'Start the fit' }).waitFor();
    await tabTo(visit, /^Name/);
    await keyboard.type('by keyboard');
    await tabTo(visit, /Standard/);
    await keyboard.press('ArrowUp');
    await tabTo(visit, /^Seed/);
    await keyboard.type('3');
    await tabTo(visit, /^Add a setting/);
    await keyboard.press('Enter');
    await keyboard.type('refine.passes');
    await keyboard.press('Escape');
    await keyboard.press('Tab');
    await keyboard.type('4');
    await tabTo(visit, /^Add a setting/);
    await keyboard.press('Enter');
    await keyboard.type('graph.max_nodes');
    await keyboard.press('Escape');
    await keyboard.press('Tab');
    await keyboard.type('20');
    await keyboard.press('Enter');
    await visit.heading('by keyboard');
    await page.getByRole('link', { name: 'Play with the twin' }).waitFor({ timeout: 600_000 });
    await tabTo(visit, /^Edit name, note and tags/);
    await keyboard.press('Enter');
    await keyboard.press('End');
    await keyboard.type(', renamed');
    await keyboard.press('Enter');
    await visit.heading('by keyboard, renamed');
    await visit.stop('keyboard');
    await tabTo(visit, /^Delete/);
    await keyboard.press('Enter');
    await page.getByRole('dialog').waitFor();
    await keyboard.press('Escape');
    await page.getByRole('dialog').waitFor({ state: 'detached' });
    await tabTo(visit, /^Delete/);
    await visit.close();
  });

  it('let several captures be tagged and deleted, and one be searched', async () => {
    const visit = await Visit.open(browser, server, { at: '/fits/new' });
    const { page } = visit;
    const field = page.getByRole('combobox', { name: 'Capture' });
    await field.fill('onerror');
    const options = page.getByRole('listbox', { name: 'Capture' }).getByRole('option');
    await expect.poll(() => options.count()).toBe(2);
    await visit.stop('fit-capture-choice');
    // The newer one is broken: it says why, and is not chosen.
    expect(await options.nth(0).getAttribute('aria-disabled')).toBe('true');
    await options.nth(0).getByText('cannot be fitted').waitFor();
    await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    expect(await options.count()).toBe(2);
    await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    await expect.poll(() => field.inputValue()).toBe(NAME.trim());
    expect(await options.count()).toBe(0);
    await visit.go('/captures');
    await page.getByText('2 captures', { exact: true }).waitFor();
    await page.getByRole('cell', { name: 'mm' }).waitFor();
    for (const box of await page.getByRole('checkbox').all()) await box.check();
    const bar = page.getByRole('region', { name: 'Selection' });
    await bar.getByText('2 captures selected').waitFor();
    await bar.getByRole('button', { name: 'Add tags' }).click();
    await bar.getByLabel('Tags to add').fill('together');
    await visit.stop('captures-selected');
    await page.keyboard.press('Enter');
    await expect.poll(() => page.getByRole('link', { name: 'together' }).count()).toBe(2);
    await expect.poll(() => bar.isVisible()).toBe(false);
    await page.getByLabel('State').selectOption('unusable');
    await page.getByText(/^1 capture with state “\u2068unusable\u2069”$/).waitFor();
    await page.getByRole('checkbox').check();
    await bar.getByRole('button', { name: 'Delete' }).click();
    await page.getByRole('dialog').getByText('Delete this capture?').waitFor();
    await page.getByRole('dialog').getByRole('button', { name: 'Delete' }).click();
    await page.getByText('No capture matches.').waitFor();
    await visit.go(addresses[1] ?? '');
    await page.getByRole('button', { name: 'Delete' }).click();
    await page.getByRole('dialog').getByText(/\d twins and \d fits depend on it:/).waitFor();
    await visit.stop('capture-delete');
    await page.getByRole('dialog').getByRole('button', { name: 'Cancel' }).click();
    await visit.close();
  });
});

/** Presses Tab until what has the focus is called so. */
async function tabTo({ page }: Visit, wanted: RegExp): Promise<void> {
  const name = (): Promise<string> =>
    page.evaluate(() => {
      const element = document.activeElement as HTMLInputElement | null;
      return element?.getAttribute('aria-label') ?? element?.labels?.[0]?.textContent ?? element?.textContent ?? '';
    });
  for (let presses = 0; presses < 60; presses += 1) {
    if (wanted.test(await name())) return;
    await page.keyboard.press('Tab');
  }
  throw new Error(`Tab does not lead to ${wanted.source}`);
}
