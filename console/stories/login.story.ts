import { describe, expect, it } from 'vitest';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('the token', () => {
  withServer(['--workers', '0']);

  it('is asked for, a wrong one is refused, and the right one leads back', async () => {
    const visit = await Visit.open(browser, server, { at: '/workers?x=1' });
    visit.allow(/status of 401/);
    await visit.heading('Log in');
    await visit.stop('login');
    const input = visit.page.getByLabel('Token', { exact: true });
    for (const wrong of ['wrong', 'falsch-ü', 'x'.repeat(64)]) {
      await input.fill(wrong);
      await visit.page.keyboard.press('Enter');
      await visit.page.getByRole('alert').filter({ hasText: 'This is not the token of this server.' }).waitFor();
      await visit.page.getByRole('button', { name: 'Log in' }).and(visit.page.locator(':enabled')).waitFor();
    }
    await visit.stop('login-wrong');
    // An address that contains the token is as good.
    await input.fill(`${server.url}/#/twins?token=${server.token}`);
    await visit.page.getByRole('button', { name: 'Log in' }).click();
    await visit.heading('Workers');
    expect(new URL(visit.page.url()).hash).toBe('#/workers?x=1');
    await visit.page.getByText('No worker is connected.').waitFor();
    // The tab keeps it over a reload; nothing else does.
    await visit.page.reload();
    await visit.heading('Workers');
    expect(await visit.page.evaluate(() => [localStorage.length, document.cookie])).toEqual([0, '']);
    await visit.page.getByRole('button', { name: 'Log out' }).click();
    await visit.heading('Log in');
    await visit.go('/workers');
    await visit.heading('Log in');
    await visit.close();
  });

  it('is known to tabs beside each other, and forgotten by all of them', async () => {
    const visit = await Visit.open(browser, server, { at: `/?token=${server.token}` });
    visit.allow(/status of 401/);
    await visit.page.getByRole('list', { name: 'What is here' }).waitFor();
    const beside = await visit.page.context().newPage();
    await beside.goto(`${server.url}/#/workers`);
    await beside.getByText('No worker is connected.').waitFor();
    await beside.getByRole('button', { name: 'Log out' }).click();
    await visit.heading('Log in');
    await beside.getByRole('heading', { name: 'Log in' }).waitFor();
    await visit.close();
    const stranger = await Visit.open(browser, server);
    stranger.allow(/status of 401/);
    await stranger.heading('Log in');
    await stranger.close();
  });

  it('is asked for, or taken from another tab, by pages that ask for nothing at first', async () => {
    const visit = await Visit.open(browser, server, { at: '/upload' });
    visit.allow(/status of 401/);
    await visit.heading('Log in');
    await visit.page.getByLabel('Token', { exact: true }).fill(server.token);
    await visit.page.keyboard.press('Enter');
    await visit.heading('Upload');
    for (const at of ['/upload', '/plays/01999999-9999-7999-8999-999999999999']) {
      const beside = await visit.page.context().newPage();
      await beside.goto(`${server.url}/#${at}`);
      await beside.locator('main .page:not([aria-busy])').waitFor();
      await beside.getByRole('button', { name: 'Log out' }).waitFor();
      await beside.close();
    }
    await visit.close();
  });

  it('is taken out of an address that has it', async () => {
    const visit = await Visit.open(browser, server, { at: `/workers?token=${server.token}` });
    await visit.heading('Workers');
    expect(visit.page.url()).toBe(`${server.url}/#/workers`);
    await visit.close();
  });

  it('leads to no other site', async () => {
    const next = encodeURIComponent('https://evil.example/#/');
    const visit = await Visit.open(browser, server, { at: `/login?next=${next}` });
    await visit.page.getByLabel('Token', { exact: true }).fill(server.token);
    await visit.page.keyboard.press('Enter');
    await visit.heading('BendTwin');
    expect(visit.page.url()).toBe(`${server.url}/#/`);
    await visit.close();
  });
});
