import { describe, expect, it } from 'vitest';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('a server that is killed', () => {
  withServer();

  it('is asked until it answers again, and the page goes on', async () => {
    const visit = await Visit.open(browser, server, { at: '/workers' });
    visit.allow(/ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE/);
    const lost = visit.page.getByText('The server does not answer. Trying again');
    const workers = visit.page.getByRole('list', { name: 'Workers' });
    await workers.waitFor();
    await server.kill();
    await lost.waitFor();
    await visit.stop('server-lost');
    // A page that is opened meanwhile waits, too.
    await visit.go('/');
    await visit.page.getByRole('alert').getByText('the page keeps trying').waitFor();
    await server.start();
    await lost.waitFor({ state: 'hidden' });
    await visit.page.getByRole('list', { name: 'What is here' }).waitFor();
    expect(await visit.page.evaluate(() => location.hash)).toBe('#/');
    await visit.go('/workers');
    await workers.waitFor();
    await visit.stop('server-back');
    await visit.close();
  });
});
