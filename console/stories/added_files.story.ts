import { openAsBlob, readdirSync, rmSync, statSync } from 'node:fs';
import { join, relative } from 'node:path';
import { beforeAll, describe, expect, it } from 'vitest';
import { tar } from '../src/pages/upload/tar';
import { call, folder, makeCapture, until } from './kit/made';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('files that are added to a recording', () => {
  withServer();
  let capture: string;
  let masks: Buffer;
  beforeAll(async () => {
    const made = makeCapture(join(folder(), 'plain'), 'toy', '--raw');
    masks = await archive(made, 'mask');
    for (const name of ['mask', 'cotracker', 'shape', 'gt_track_3d.pkl']) rmSync(join(made, name), { recursive: true });
    const query = new URLSearchParams({ display_name: 'plain' });
    capture = (await call<{ name: string }>(server, 'POST', `/v1/captures?${query}`, await archive(made, ''))).name;
    await until(async () => (await call<Capture>(server, 'GET', `/v1/${capture}`)).ingest.state === 'FAILED');
  });

  it('are masks of another tool, which take effect when it is read again, and are removed', async () => {
    const visit = await Visit.open(browser, server, { at: `/${capture}` });
    const { page } = visit;
    await page.locator('.findings').getByText('MASKS_MISSING').waitFor();
    await page.getByRole('link', { name: /guide/ }).first().waitFor();
    await page.getByText('First images').waitFor();
    await page.getByText(/^What was read/).click();
    await page.getByText('Add masks or a calibration').click();
    await page.getByLabel('Masks of another tool').setInputFiles({ name: 'masks.tar', mimeType: '', buffer: masks });
    await page.getByText('It takes effect when the recording is read again').waitFor();
    await visit.stop('capture-with-added-masks');
    await page.getByRole('button', { name: 'Read again', exact: true }).first().click();
    await page.getByRole('link', { name: 'Start a fit' }).waitFor();
    expect(await page.getByText('MASKS_MISSING').count()).toBe(0);
    const download = page.waitForEvent('download');
    await page.getByRole('link', { name: 'Download', exact: true }).click();
    await (await download).path();
    await page.getByRole('button', { name: 'Remove', exact: true }).click();
    await page.getByRole('dialog').getByRole('button', { name: 'Remove' }).click();
    await page.getByText('Masks of another tool: removed').waitFor();
    const { supplements } = await call<Capture>(server, 'GET', `/v1/${capture}`);
    expect(supplements).toEqual([]);
    await visit.stop('capture-without-added-masks');
    await visit.close();
  });

  it('that are no calibration are refused immediately, in words', async () => {
    const viewport = { width: 360, height: 740 };
    const visit = await Visit.open(browser, server, { at: `/${capture}`, viewport, colorScheme: 'dark' });
    visit.allow(/status of 400/);
    const { page } = visit;
    await page.getByText('Add masks or a calibration').click();
    const file = { name: 'calibration.json', mimeType: 'application/json', buffer: Buffer.from('{"format":"other"}') };
    await page.getByLabel('Calibration', { exact: true }).setInputFiles(file);
    await page.getByRole('alert').filter({ hasText: 'bendtwin capture calibrate' }).first().waitFor();
    expect(await page.getByText('It takes effect when the recording is read again').count()).toBe(0);
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(360);
    await visit.stop('capture-wrong-calibration');
    await visit.close();
  });
});

interface Capture {
  readonly ingest: { readonly state: string };
  readonly supplements: readonly unknown[];
}

/** The files of a folder below another one as a tar archive. */
async function archive(root: string, below: string): Promise<Buffer> {
  const names = readdirSync(join(root, below), { recursive: true, encoding: 'utf8' }).map((name) => join(root, below, name));
  const paths = names.filter((path) => statSync(path).isFile()).sort();
  const files = await Promise.all(paths.map(async (path) => ({ path: relative(root, path), file: await openAsBlob(path) })));
  return Buffer.from(await tar(files).arrayBuffer());
}
