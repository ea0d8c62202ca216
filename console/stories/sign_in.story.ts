import { spawn } from 'node:child_process';
import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, it } from 'vitest';
import { Server, binary } from '../scripts/server.mjs';
import { confirm, startIdentity } from './kit/identity';
import type { Identity } from './kit/identity';
import { Visit, launch } from './kit/visit';

let identity: Identity;
let server: Server;
let browser: Browser;

beforeAll(async () => {
  identity = await startIdentity();
  const options = ['--config', identity.config, '--workers', '0'];
  [server, browser] = await Promise.all([Server.start(options, identity.port), launch()]);
});

afterEach(async () => {
  await Promise.all(browser.contexts().map((context) => context.close()));
});

afterAll(async () => {
  await browser.close();
  await server.remove();
  identity.close();
});

/** A visit to a page of the console, from which somebody signs in. */
async function signIn(at: string, account: string): Promise<Visit> {
  const visit = await Visit.open(browser, server, { at });
  visit.allow(/status of 401/, ...ofProvider());
  await visit.heading('Log in');
  await visit.page.getByRole('button', { name: 'Sign in with the lab' }).waitFor();
  await visit.stop('sign-in');
  await visit.page.getByRole('button', { name: 'Sign in with the lab' }).click();
  await confirm(visit.page, account);
  return visit;
}

/** What the provider's pages ask for, which are not the console's. */
function ofProvider(): RegExp[] {
  return [new RegExp(identity.issuer), /fonts\.googleapis\.com/];
}

/** What the server says to the holder of a key. */
async function callerOf(key: string): Promise<{ owner?: string; reason?: string }> {
  const answer = await fetch(`${server.url}/v1/caller`, { headers: { authorization: `Bearer ${key}` } });
  return (await answer.json()) as { owner?: string; reason?: string };
}

const keyOf = (visit: Visit): Promise<string> =>
  visit.page.evaluate(() => sessionStorage.getItem('bendtwin.token') ?? '');

describe('signing in with an identity provider', () => {
  it('leads back, leaves no trace in the address, and ends by signing out', async () => {
    const visit = await signIn('/workers?x=1', 'ada');
    // The page also asks for what is the administrators'.
    visit.allow(/status of 403 .*usage\/owners/);
    await visit.heading('Workers');
    expect(visit.page.url()).toBe(`${server.url}/#/workers?x=1`);
    const key = await keyOf(visit);
    expect(key).toMatch(/^bt_/);
    expect((await callerOf(key)).owner).toBe('ada@example.org');
    await visit.page.locator('header').getByText('ada@example.org').waitFor();
    const kept = await visit.page.evaluate(() => [localStorage.length, sessionStorage.length, document.cookie]);
    expect(kept).toEqual([0, 1, '']);
    expect(await server.run('key', 'list')).toMatch(/signed in until .*ada@example\.org/);
    await visit.page.getByRole('button', { name: 'Log out' }).click();
    await visit.heading('Log in');
    await expect.poll(async () => (await callerOf(key)).reason).toBe('SIGN_IN_ENDED');
    await visit.close();
  });

  it('is not taken over from another tab, or done twice', async () => {
    const visit = await Visit.open(browser, server);
    visit.allow(/status of 401/, ...ofProvider());
    await visit.heading('Log in');
    let address = '';
    visit.page.on('request', (request) => {
      if (request.url().includes('/sign-in?')) address = request.url();
    });
    let proof = '';
    visit.page.on('request', (request) => {
      if (request.url().endsWith('/v1/sign-in') && request.method() === 'POST') proof = request.postData() ?? '';
    });
    await visit.page.getByRole('button', { name: 'Sign in with the lab' }).click();
    await confirm(visit.page, 'ada');
    await visit.heading('BendTwin');
    // The same code again, by somebody who saw everything.
    const replayed = await fetch(`${server.url}/v1/sign-in`, {
      method: 'POST',
      headers: { 'content-type': 'application/json' },
      body: proof,
    });
    expect([replayed.status, ((await replayed.json()) as { reason: string }).reason]).toEqual([403, 'SIGN_IN_REFUSED']);
    // The address of the return, in a tab that began nothing.
    const stranger = await visit.page.context().newPage();
    await stranger.goto(address);
    await stranger.getByRole('alert').filter({ hasText: 'was not begun in this tab' }).waitFor();
    expect(stranger.url()).toBe(`${server.url}/#/login`);
    await visit.close();
  });

  it('begins at the address to which the provider sends browsers back', async () => {
    const visit = await Visit.open(browser, server);
    const elsewhere = server.url.replace('127.0.0.1', 'localhost');
    visit.allow(/status of 401/, new RegExp(elsewhere), ...ofProvider());
    await visit.page.goto(`${elsewhere}/#/workers?x=1`);
    await visit.heading('Log in');
    // The token is for those who run the server.
    await visit.page.getByText('Log in with the token or a key').waitFor();
    expect(await visit.page.getByLabel('Token', { exact: true }).isVisible()).toBe(false);
    await visit.page.getByText('Sign-in is at another address of this server').waitFor();
    await visit.page.getByRole('button', { name: 'Sign in with the lab' }).click();
    await visit.page.waitForURL(`${server.url}/#/login?next=*`);
    await visit.page.getByRole('button', { name: 'Sign in with the lab' }).click();
    await confirm(visit.page, 'ada');
    visit.allow(/status of 403 .*usage\/owners/);
    await visit.heading('Workers');
    expect(visit.page.url()).toBe(`${server.url}/#/workers?x=1`);
    await visit.close();
  });

  it('says why somebody is not let in', async () => {
    const visit = await signIn('/', 'mallory');
    visit.allow(/status of 403/);
    await visit.page.getByRole('alert').filter({ hasText: 'has not verified the address mallory@example.org' }).waitFor();
    await visit.stop('sign-in-refused');
    await visit.page.getByRole('button', { name: 'Sign in with the lab' }).waitFor();
    await visit.close();
  });

  it('shows what the provider says as text', async () => {
    const visit = await Visit.open(browser, server);
    visit.allow(/status of 401/);
    await visit.heading('Log in');
    await visit.page.evaluate(() => {
      sessionStorage.setItem('bendtwin.sign-in', JSON.stringify({ state: 's', nonce: 'n', verifier: 'v', next: '#/' }));
    });
    await visit.page.goto(`${server.url}/sign-in?state=s&error=access_denied&error_description=%3Cimg%20src%3Dx%3E`);
    await visit.page.getByRole('alert').filter({ hasText: 'refused: <img src=x>' }).waitFor();
    await visit.close();
  });

  it('ends when an administrator ends it', async () => {
    const visit = await signIn('/', 'grace');
    await visit.heading('BendTwin');
    await visit.page.getByRole('button', { name: 'Log out' }).waitFor();
    const robot = await server.run('key', 'create', 'robot', '--owner', 'grace@example.org', '--scope', 'twins:read');
    const revoked = await server.run('key', 'revoke', '--owner', 'grace@example.org', '--sign-ins');
    expect(revoked).toContain('revoked 1');
    expect((await callerOf(robot.trim())).owner).toBe('grace@example.org');
    await visit.go('/twins');
    await visit.page.getByText('Your sign-in has ended. Sign in again.').waitFor();
    await visit.stop('sign-in-ended');
    // The key that has ended is still in the tab, and does not keep its person out.
    await visit.page.getByRole('button', { name: 'Sign in with the lab' }).click();
    await visit.page.getByRole('button', { name: 'Continue' }).click();
    await visit.heading('Twins');
    await visit.close();
  });
});

/** Runs `bendtwin login`, which somebody confirms in a browser. */
async function logIn(account: string): Promise<void> {
  const login = spawn(binary(), ['login', '--no-browser'], { env: server.environment });
  let asked = '';
  let printed = '';
  login.stderr.on('data', (piece: Buffer) => (asked += piece.toString()));
  login.stdout.on('data', (piece: Buffer) => (printed += piece.toString()));
  const ended = new Promise<number | null>((resolve) => login.on('exit', resolve));
  await expect.poll(() => asked).toMatch(/Open \S+ and enter the code \S+/);
  const [, address = '', code = ''] = /Open (\S+) and enter the code (\S+)/.exec(asked) ?? [];
  const context = await browser.newContext();
  const page = await context.newPage();
  await page.goto(address);
  await page.locator('input[name=user_code]').fill(code);
  await page.getByRole('button', { name: 'Continue' }).click();
  await page.getByRole('button', { name: 'Continue' }).click();
  await confirm(page, account);
  expect([await ended, asked]).toEqual([0, asked]);
  expect(printed).toContain(`signed in as ${account}@example.org until`);
  await context.close();
}

/** Names of the keys with which somebody is signed in. */
async function validSignIns(account: string): Promise<string[]> {
  const answer = await fetch(`${server.url}/v1/keys`, { headers: { authorization: `Bearer ${server.token}` } });
  const { keys } = (await answer.json()) as { keys: { name: string; owner: string; revoke_time: string | null }[] };
  return keys.filter((key) => key.owner === `${account}@example.org` && key.revoke_time === null).map((key) => key.name);
}

describe('bendtwin login', () => {
  it('waits for a person with a browser, keeps a key, and removes it', async () => {
    expect(await server.run('whoami')).toContain('local');
    await logIn('linus');
    expect(await server.run('whoami')).toMatch(/^linus@example\.org, signed in until .*\nscopes: captures:read, fits:read, twins:read/);
    await server.run('twin', 'list');
    await expect(server.run('key', 'list')).rejects.toThrow('admin');
    // A second sign-in takes the place of the first one, and ends it.
    const first = await validSignIns('linus');
    expect(first).toHaveLength(1);
    await logIn('linus');
    const second = await validSignIns('linus');
    expect(second).toHaveLength(1);
    expect(second).not.toEqual(first);
    expect(await server.run('logout')).toContain('signed out');
    expect(await server.run('logout')).toContain('not signed in');
    expect(await server.run('whoami')).toContain('local');
  });
});
