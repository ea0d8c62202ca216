import { cpSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { join, relative } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { Server } from '../scripts/server.mjs';
import { call, folder, makeCapture, padded, until } from './kit/made';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

interface Captures {
  captures: { display_name: string; verdict: string | null; note: string; tags: string[]; size_bytes: number }[];
}

describe('uploads', () => {
  withServer();
  const files = folder();
  const rope = join(files, 'rope.zip');
  const toy = join(files, 'toy');
  beforeAll(async () => {
    makeCapture(rope, 'rope');
    makeCapture(toy, 'toy', '--raw');
    writeFileSync(join(toy, 'film.mp4'), new Uint8Array(3_000_000));
  });
  afterAll(async () => {
    rmSync(files, { recursive: true });
  });

  const all = async (): Promise<Captures['captures']> => (await call<Captures>(server, 'GET', '/v1/captures')).captures;

  it('begin where a file and a folder are dropped, on any page', async () => {
    const visit = await Visit.open(browser, server, { at: '/workers' });
    await visit.heading('Workers');
    await drop(visit.page, [rope, toy], () => visit.stop('upload-drop'));
    await visit.heading('Upload');
    const rows = visit.page.getByRole('list', { name: 'Uploads' }).getByRole('listitem');
    // What has arrived is not called good before it was read.
    await expect.poll(() => rows.getByText('good', { exact: true }).count()).toBe(2);
    await rows.getByText('This recording is good: nothing limits a fit.').waitFor();
    await rows.getByText('Raw recording, 2 cameras').waitFor();
    // The film that nobody reads stays here.
    await visit.page.getByText('1 other file not needed and left out').waitFor();
    await visit.stop('upload-done');
    await until(async () => (await all()).every(({ verdict }) => verdict === 'good'));
    const sent = (await all()).find(({ display_name }) => display_name === 'toy');
    expect(sent?.size_bytes).toBeLessThan(2_500_000);
    await rows.filter({ hasText: 'toy' }).getByRole('link', { name: 'Open the capture' }).click();
    await visit.heading('toy');
    await visit.page.getByText('This recording is good').waitFor();
    await expect.poll(() => visit.page.locator('.timelines canvas').count()).toBeGreaterThan(4);
    await visit.page.getByRole('heading', { name: 'Pictures' }).scrollIntoViewIfNeeded();
    await expect
      .poll(() =>
        visit.page
          .locator('.pictures img')
          .evaluateAll((i) => i.every((p) => (p as HTMLImageElement).naturalWidth > 0)),
      )
      .toBe(true);
    await visit.stop('capture');
    // A frame that is clicked is played.
    await visit.page.locator('.timelines .u-over').nth(1).click({ position: { x: 300, y: 30 } });
    await visit.heading('Playback of toy');
    expect(new URL(visit.page.url()).hash).toMatch(/playback\?frame=\d+/);
    await visit.close();
  });

  it('of recordings that lack something show what, and wait; their verdict is on the card', async () => {
    const plain = join(files, 'plain');
    cpSync(toy, plain, { recursive: true, filter: (path) => !/mask|film/.test(path) });
    const visit = await Visit.open(browser, server, { at: '/upload' });
    const { page } = visit;
    await page.getByLabel('Choose a folder').setInputFiles(plain);
    const offer = page.getByRole('list', { name: 'Ready to upload' }).getByRole('listitem');
    await offer.getByText('no masks', { exact: true }).waitFor();
    await offer.getByText('you can mark the object and the hand after the upload').waitFor();
    await visit.stop('upload-survey');
    await offer.getByRole('button', { name: 'Upload plain' }).click();
    const row = page.getByRole('list', { name: 'Uploads' }).getByRole('listitem');
    await row.getByText('unusable', { exact: true }).waitFor();
    await row.getByText('This recording cannot be fitted: no camera has a mask').waitFor();
    await visit.stop('upload-unusable');
    await row.getByRole('link', { name: 'See what to do' }).click();
    await visit.heading('plain');
    await page.getByRole('link', { name: 'Mark the object and the hand' }).first().waitFor();
    await visit.close();
  });

  it('of what was uploaded before say so', async () => {
    const visit = await Visit.open(browser, server, { at: '/upload' });
    const before = (await all()).length;
    await visit.page.getByLabel('Choose files').setInputFiles(rope);
    const row = visit.page.getByRole('list', { name: 'Uploads' }).getByRole('listitem');
    await row.getByText(/^(good|already exists)$/).first().waitFor();
    await visit.page.getByRole('button', { name: 'Clear' }).click();
    await visit.page.getByLabel('Choose files').setInputFiles(rope);
    await row.getByText('already exists').waitFor();
    expect((await all()).length).toBeLessThanOrEqual(before + 1);
    await visit.close();
  });

  it('refuse files that are not captures, and say what to do', async () => {
    const visit = await Visit.open(browser, server, { at: '/upload' });
    const chosen = { name: 'film.mp4', mimeType: 'video/mp4', buffer: Buffer.from('no archive at all') };
    await visit.page.getByLabel('Choose files').setInputFiles(chosen);
    await visit.page.getByText('film.mp4 is not a capture: send a folder').waitFor();
    const program = { name: 'setup.zip', mimeType: 'application/zip', buffer: Buffer.from('MZ\x90') };
    await visit.page.getByLabel('Choose files').setInputFiles(program);
    await visit.page.getByText('setup.zip is a Windows program, not a capture').waitFor();
    // A refusal stays until it was read.
    await visit.go('/captures');
    await visit.heading('Captures');
    await visit.go('/upload');
    await visit.page.getByText('film.mp4 is not a capture').waitFor();
    await visit.stop('upload-refused');
    await visit.page.getByRole('button', { name: /^Dismiss: film/ }).click();
    await expect.poll(() => visit.page.getByText(/is not a capture|not a capture:/).count()).toBe(1);
    await visit.close();
  });

  it('go on after the server was killed, and after the page was left', async () => {
    const archive = join(files, 'long.tar');
    writeFileSync(archive, await padded(listed(toy), 24 * 2 ** 20));
    const visit = await Visit.open(browser, server, { at: '/upload' });
    const { page } = visit;
    visit.allow(/ERR_CONNECTION|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE|ERR_FAILED|status of 4(04|23)/);
    page.on('dialog', (dialog) => void dialog.accept());
    await slow(page, 3_000_000);
    await page.getByText('Facts and settings of the next files').click();
    await page.getByLabel('Note').fill('left hand');
    await page.getByLabel('Tags').fill('wet slow');
    await page.getByLabel('Choose files').setInputFiles(archive);
    const row = page.getByRole('list', { name: 'Uploads' }).getByRole('listitem');
    const offset = async (): Promise<number> => Number(await row.getByRole('progressbar').getAttribute('value'));
    await expect.poll(offset, { timeout: 60_000 }).toBeGreaterThan(0.1);
    await server.kill();
    await row.getByText('interrupted', { exact: true }).waitFor();
    await row.getByText('the upload continues by itself').waitFor();
    await visit.stop('upload-interrupted');
    await server.start();
    const before = await offset();
    await expect.poll(offset, { timeout: 60_000 }).toBeGreaterThan(before);
    await page.reload();
    await page.getByText('These uploads were begun in this browser').waitFor();
    await visit.stop('upload-left');
    const chooser = page.waitForEvent('filechooser');
    await page.getByRole('listitem').getByRole('button', { name: 'Choose the file' }).click();
    await (await chooser).setFiles(archive);
    // It goes on where it was, not at the beginning.
    await row.getByText('uploading', { exact: true }).waitFor();
    await expect.poll(offset).toBeGreaterThanOrEqual(before);
    await slow(page, -1);
    await row.getByText(/^(uploaded|waits|reading|good)$/).first().waitFor({ timeout: 600_000 });
    const stored = (await all()).filter(({ display_name }) => display_name === 'long');
    expect(stored).toMatchObject([{ note: 'left hand', tags: ['slow', 'wet'], size_bytes: statSync(archive).size }]);
    expect(await page.evaluate(() => localStorage.getItem('bendtwin.uploads'))).toBe('[]');
    await visit.close();
  });

  it('and downloads show the token of a server that asks for it', async () => {
    const guarded = await Server.start(['--workers', '0']);
    try {
      const visit = await Visit.open(browser, guarded, { at: `/upload?token=${guarded.token}` });
      await visit.page.getByLabel('Choose files').setInputFiles(rope);
      await visit.page.getByRole('link', { name: 'Open the capture' }).click();
      await visit.heading('rope');
      const download = visit.page.waitForEvent('download');
      await visit.page.getByRole('button', { name: 'Download the recording' }).click();
      expect(readFileSync(await (await download).path()).equals(readFileSync(rope))).toBe(true);
      await visit.close();
    } finally {
      await guarded.remove();
    }
  });

  it('can be cancelled, and leave nothing behind', async () => {
    const visit = await Visit.open(browser, server, { at: '/upload' });
    await slow(visit.page, 500_000);
    const buffer = Buffer.concat([Buffer.from('PK\x03\x04'), Buffer.alloc(8 * 2 ** 20)]);
    await visit.page
      .getByLabel('Choose files')
      .setInputFiles({ name: 'other.zip', mimeType: 'application/zip', buffer });
    // Of a damaged archive is not known what it has.
    await visit.page.getByText('It seems to be damaged or cut off').waitFor();
    await visit.page.getByRole('button', { name: 'Upload other' }).click();
    const row = visit.page.getByRole('list', { name: 'Uploads' }).getByRole('listitem');
    await row.getByText('uploading', { exact: true }).waitFor();
    await row.getByRole('button', { name: 'Cancel other' }).click();
    await row.getByText('cancelled', { exact: true }).waitFor();
    const uploads = async (): Promise<{ uploads: { display_name: string; state: string }[] }> =>
      call(server, 'GET', '/v1/uploads');
    await until(async () => (await uploads()).uploads.every((u) => u.display_name !== 'other' || u.state === 'GONE'));
    expect((await all()).some(({ display_name }) => display_name === 'other')).toBe(false);
    await row.getByRole('button', { name: 'Clear other' }).click();
    await expect.poll(() => row.count()).toBe(0);
    await visit.close();
  });
});

/** Drops files and folders of the disk on a page, as a person would; `over` is called before they are let go. */
async function drop(page: Page, paths: readonly string[], over: () => Promise<void>): Promise<void> {
  const session = await page.context().newCDPSession(page);
  const data = { items: [], files: [...paths], dragOperationsMask: 1 };
  const at = { x: 600, y: 400, data };
  await session.send('Input.dispatchDragEvent', { type: 'dragEnter', ...at });
  await session.send('Input.dispatchDragEvent', { type: 'dragOver', ...at });
  await page.getByText('Drop to upload').waitFor();
  await over();
  // As a hand does that is not quite still: the page says anew that it takes what is held over it.
  for (const x of [601, 602]) await session.send('Input.dispatchDragEvent', { type: 'dragOver', ...at, x });
  await session.send('Input.dispatchDragEvent', { type: 'drop', ...at, x: 602 });
}

/** Limits how fast a page sends [bytes/s]; -1 is no limit. */
async function slow(page: Page, uploadThroughput: number): Promise<void> {
  const session = await page.context().newCDPSession(page);
  await session.send('Network.enable');
  await session.send('Network.emulateNetworkConditions', {
    offline: false,
    latency: 0,
    downloadThroughput: -1,
    uploadThroughput,
  });
}

/** Files below a folder by their names in an archive. */
function listed(path: string): Record<string, string> {
  const found = readdirSync(path, { recursive: true, withFileTypes: true }).filter((entry) => entry.isFile());
  const places = found.map((entry) => join(entry.parentPath, entry.name)).filter((place) => !place.endsWith('.mp4'));
  return Object.fromEntries(places.sort().map((place) => [`toy/${relative(path, place)}`, place]));
}
