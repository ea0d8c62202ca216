import type { BrowserContextOptions } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import { lift } from './kit/drag';
import { fittedRope } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('a link to a twin', () => {
  withServer([]);
  let twin: string;
  beforeAll(async () => {
    twin = await fittedRope(server, 'blue rope');
  });

  async function owner(at: string): Promise<Visit> {
    const visit = await Visit.open(browser, server, { at: `${at}?token=${server.token}` });
    await visit.heading('blue rope');
    return visit;
  }

  /** Makes a link in the dialog that is open. */
  async function made({ page }: Visit, whom: string): Promise<string> {
    await page.getByLabel('For', { exact: true }).fill(whom);
    await page.getByRole('button', { name: 'Create link' }).click();
    return page.getByRole('textbox', { name: 'Link' }).inputValue();
  }

  /** Opens a link in a fresh profile. */
  async function visit(link: string, options: BrowserContextOptions = {}): Promise<Visit> {
    const opened = await Visit.open(browser, server, { ...options, at: link.split('#')[1]! });
    opened.allow(/status of 40[13]/, /WebSocket/);
    return opened;
  }

  it('is made, opened by someone without a token, played, and revoked', async () => {
    const ada = await owner(`/twins/${twin}`);
    await ada.page.getByRole('button', { name: 'Share', exact: true }).click();
    const link = await made(ada, 'the board');
    expect(link).toContain(`/#/shared/${twin}?key=bt_`);
    await ada.page.getByText('not used yet').waitFor();
    await ada.stop('share-dialog');

    const eve = await visit(link, { hasTouch: true, viewport: { width: 390, height: 844 } });
    const { page } = eve;
    await eve.heading('blue rope');
    await page.getByRole('button', { name: 'Play' }).waitFor();
    expect(page.url()).not.toContain('bt_');
    expect(await page.getByRole('navigation').count()).toBe(0);
    expect(await page.getByRole('button', { name: 'Download' }).count()).toBe(0);
    await eve.stop('share-visit');
    // A visit that is loaded again needs no other link.
    await page.reload();
    await page.getByRole('button', { name: 'Play' }).click();
    await page.getByText('frames/s simulated').waitFor();
    await lift(page);
    await eve.stop('share-play');
    // The key opens no other page.
    expect(await page.evaluate(() => sessionStorage.getItem('bendtwin.token'))).toBeNull();

    await ada.page.getByRole('button', { name: 'Revoke: the board' }).click();
    await ada.page.getByRole('dialog', { name: 'Revoke this link?' }).getByRole('button', { name: 'Revoke' }).click();
    await eve.heading('This link has expired');
    await page.getByText('Ask the person who sent it for a new one.').waitFor();
    await eve.stop('share-ended');
    await page.reload();
    await eve.heading('This link has expired');
    await eve.close();
    await ada.close();
  });

  it('from the playground opens where the object was, and leaves the token of its visitor alone', async () => {
    const ada = await owner(`/twins/${twin}/play`);
    const { page } = ada;
    await page.getByText('frames/s simulated').waitFor();
    await page.getByRole('button', { name: 'Link for anyone' }).click();
    await page.getByRole('checkbox', { name: 'Allow downloads of the twin' }).check();
    const link = await made(ada, '');
    expect(new URLSearchParams(link.split('?')[1]).get('points')).toMatch(/^\S{20,}$/);
    await page.getByRole('button', { name: 'Close' }).click();
    // In a tab that has a token.
    await ada.go(link.split('#')[1]!);
    await page.getByRole('button', { name: 'Download' }).waitFor();
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Download' }).click();
    expect((await download).suggestedFilename()).toBe(`${twin}.safetensors`);
    await ada.stop('share-download');
    await ada.go('/twins');
    await page.getByRole('link', { name: 'blue rope' }).first().waitFor();
    expect(await page.getByRole('navigation').count()).toBe(1);
    await ada.close();
  });

  it('that is incomplete says what to do', async () => {
    const eve = await visit(`/#/shared/${twin}?key=bt_1`);
    await eve.heading('This link does not work');
    await eve.close();
  });
});

describe('a link to a twin of a server without a token', () => {
  withServer();

  it('needs no key', async () => {
    const twin = await fittedRope(server, 'red rope');
    const ada = await Visit.open(browser, server, { at: `/twins/${twin}` });
    await ada.page.getByRole('button', { name: 'Share', exact: true }).click();
    await ada.page.getByText('it does not expire').waitFor();
    const link = await ada.page.getByRole('textbox', { name: 'Link' }).inputValue();
    expect(link).toBe(`${server.url}/#/shared/${twin}`);
    await ada.go(`/shared/${twin}`);
    await ada.page.getByRole('button', { name: 'Play' }).waitFor();
    await ada.close();
  });
});
