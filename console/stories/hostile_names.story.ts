import { describe, expect, it } from 'vitest';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

const ZIP = { 'content-type': 'application/zip' };

/** Names that would be markup, scripts, or would turn the text around them, if they were taken for more than text. */
const NAMES = [
  '<img src=x onerror="document.title=1">',
  '</title><script>document.title=2</script>',
  '\u202Eمرحبا evil <b>bold</b>',
  '{{7*7}} ${7*7} %s \u0000',
  `javascript:document.title=3`,
  '"><svg onload=document.title=4>',
  'x'.repeat(200),
  '👩‍🔬'.repeat(20),
];

/** Elements that the names would make. */
const ELEMENTS = 'main [src=x], main script, main b, main [onload], main [onerror]';

describe('hostile names', () => {
  withServer(['--client-token', 'none', '--workers', '0']);

  it('are text wherever they are shown', async () => {
    const names: string[] = [];
    const pages: string[] = [];
    for (const display_name of NAMES) {
      const query = new URLSearchParams({ display_name });
      const answer = await fetch(`${server.url}/v1/captures?${query}`, { method: 'POST', body: 'no archive', headers: ZIP });
      const capture = (await answer.json()) as { name?: string; display_name?: string };
      if (capture.name === undefined || capture.display_name === undefined) continue;
      names.push(capture.display_name);
      const body = JSON.stringify({ capture: capture.name });
      const headers = { 'content-type': 'application/json' };
      const queued = await fetch(`${server.url}/v1/fits`, { method: 'POST', body, headers });
      const fit = (await queued.json()) as { name: string };
      if (display_name === NAMES[0]) pages.push(`/${capture.name}`, `/${fit.name}`);
    }
    expect(names.length).toBeGreaterThanOrEqual(6);
    const visit = await Visit.open(browser, server);
    await visit.page.getByRole('list', { name: 'What is here' }).waitFor();
    for (const name of names.slice(-5)) {
      expect(await visit.page.locator('bdi').filter({ hasText: name }).first().textContent()).toBe(name);
    }
    await visit.stop('hostile-names');
    for (const at of ['/', '/captures', '/fits', ...pages]) {
      await visit.go(at);
      await visit.page.getByText(NAMES[0] ?? '').or(visit.page.getByText(NAMES[5] ?? '')).first().waitFor();
      expect(await visit.page.locator(ELEMENTS).count(), at).toBe(0);
      expect(await visit.page.title(), at).not.toMatch(/^\d$/);
      for (const size of [1200, 360]) {
        await visit.page.setViewportSize({ width: size, height: 800 });
        const message = `${at} on a screen of ${size}`;
        await expect.poll(() => width(visit), { message, timeout: 10_000 }).toBeLessThanOrEqual(size);
      }
    }
    await visit.stop('hostile-names-small');
    await visit.close();
  });

  it('of addresses lead nowhere', async () => {
    const visit = await Visit.open(browser, server, { at: '/<img src=x onerror=document.title=5>' });
    await visit.heading('Nothing here');
    await visit.go('/constructor');
    await visit.heading('Nothing here');
    await visit.close();
  });
});

function width(visit: Visit): Promise<number> {
  return visit.page.evaluate(() => document.documentElement.scrollWidth);
}
