import { rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { call, folder, makeCapture, sendCapture } from './kit/made';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('a fit that asks for a worker', () => {
  let capture = '';
  const files = folder();
  const config = join(files, 'config.toml');
  const args = ['worker', '--backend', 'cpu', '--label', 'lab=2', '--label', 'quiet'];
  writeFileSync(config, `[workers]\nargs = ${JSON.stringify(args)}\n`);
  withServer(['--config', config, '--client-token', 'none']);
  beforeAll(async () => {
    capture = await sendCapture(server, makeCapture(join(files, 'rope.zip'), 'rope'), 'rope');
  });
  afterAll(() => rmSync(files, { recursive: true }));

  it('is offered what the workers have, and learns whether one can take it', async () => {
    const visit = await Visit.open(browser, server, { at: `/fits/new?capture=${capture.split('/')[1]}` });
    const { page } = visit;
    await visit.heading('Start a fit');
    await page.getByText('Worker', { exact: true }).click();
    expect(await page.getByLabel('Kind').locator('option').allTextContents()).toEqual(['Any', 'CPU']);
    await page.getByText('1 of 1 worker can take the fit.').waitFor();
    await page.getByLabel('Kind').selectOption('CPU');
    await page.getByLabel('lab=2').check();
    await page.getByLabel('Other labels').fill('lab=3');
    await page.getByText('None of 1 worker can take the fit').waitFor();
    await page.getByLabel('Other labels').fill('');
    await page.getByText('1 of 1 worker can take the fit.').waitFor();
    await page.getByLabel('Least device memory').fill('much');
    await page.getByText('is not a size').waitFor();
    await visit.stop('fit-worker');
    await page.getByRole('button', { name: 'Start the fit' }).click();
    const memory = page.getByLabel('Least device memory');
    expect(await memory.evaluate((own) => own === document.activeElement)).toBe(true);
    await memory.fill('0.25');
    await page.getByRole('button', { name: 'Start the fit' }).click();
    await visit.heading('rope');
    await page.getByText('CPU, 268 MB of memory, lab=2').waitFor();
    const { fits } = await call<{ fits: { name: string; requirements: object }[] }>(server, 'GET', '/v1/fits');
    expect(fits[0]?.requirements).toEqual({ backend: 'cpu', memory_bytes: 2 ** 28, labels: ['lab=2'] });
    // Another fit like this one begins with the same worker.
    await visit.go(`/fits/new?like=${fits[0]?.name.split('/')[1] ?? ''}`);
    await visit.heading('Start a fit');
    expect(await page.getByLabel('lab=2').isChecked()).toBe(true);
    expect(await page.getByLabel('quiet').isChecked()).toBe(false);
    expect(await page.getByLabel('Kind').inputValue()).toBe('cpu');
    expect(await memory.inputValue()).toBe('0.25');
    await visit.close();
  });
});
