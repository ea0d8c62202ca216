import { readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { call, folder, makeCapture, sendCapture, until } from './kit/made';
import { pictureOf, type Picture } from './kit/pixels';
import { COARSE } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('fits and twins', () => {
  withServer();
  let capture = '';
  const files = folder();
  beforeAll(async () => {
    capture = await sendCapture(server, makeCapture(join(files, 'rope.zip'), 'rope'), 'rope');
  });
  afterAll(async () => {
    rmSync(files, { recursive: true });
  });

  it('start with settings, whose faults stand at their fields, and are watched to their end', async () => {
    const visit = await Visit.open(browser, server, { at: `/captures/${capture.split('/')[1]}` });
    const { page } = visit;
    visit.allow(/status of 400/);
    await page.getByRole('link', { name: 'Start a fit' }).click();
    await visit.heading('Start a fit');
    await page.getByLabel('Name', { exact: true }).fill('two starts');
    await page.getByLabel('Starts').fill('2');
    await page.getByLabel('Seed').fill('half');
    await page.getByRole('button', { name: 'Start the fit' }).click();
    await page.getByText('is not a number').waitFor();
    await page.getByLabel('Seed').fill('7');
    await page.getByLabel('Finish within').fill('0');
    for (const [index, [name, value]] of [
      ['search.generations', 'ten'],
      ['refine.pases', '30'],
    ].entries()) {
      await page.getByRole('button', { name: 'Add a setting' }).click();
      await page.getByLabel(`Setting ${index + 1}, name`).fill(name ?? '');
      await page.getByLabel(`Setting ${index + 1}, value`).fill(value ?? '');
    }
    await page.getByText('Generations; 0 skips the stage.').waitFor();
    await page.getByRole('button', { name: 'Start the fit' }).click();
    const rows = page.locator('.setting-row');
    await rows.nth(0).getByText('invalid type').waitFor();
    await rows.nth(1).getByText('unknown field').waitFor();
    expect(await page.getByLabel('Setting 1, value').getAttribute('aria-invalid')).toBe('true');
    await visit.stop('fit-wrong-settings');
    await page.getByLabel('Setting 1, value').fill('6');
    await page.getByLabel('Setting 2, name').fill('refine.passes');
    // With few nodes a pass takes a moment.
    await page.getByRole('button', { name: 'Add a setting' }).click();
    await page.getByLabel('Setting 3, name').fill('graph.max_nodes');
    await page.getByLabel('Setting 3, value').fill('30');
    await page.getByRole('button', { name: 'Start the fit' }).click();
    // The server looks at ranges once all types are right.
    await page.getByText('it must lie in 1..=1000000').waitFor();
    await page.getByLabel('Finish within').fill('');
    await page.getByRole('button', { name: 'Start the fit' }).click();
    await visit.heading('two starts');
    await page.getByRole('heading', { name: 'Losses' }).waitFor();
    // What it has so far: the prediction over the recording, and millimetres.
    await page.getByText(/^Now [\d.]+ mm \(\w+\) on the frames that it is being fitted to, standing still [\d.]+ mm\./).waitFor();
    await page.getByRole('button', { name: 'Pause' }).click();
    const [recorded, predicted] = inColours(await pictureOf(page));
    expect(recorded, 'recorded points').toBeGreaterThan(50);
    expect(predicted, 'predicted points').toBeGreaterThan(50);
    await page.getByRole('heading', { name: 'Error over training frames' }).waitFor();
    await visit.stop('fit-running');
    await page.getByRole('link', { name: 'Play with the twin' }).waitFor({ timeout: 600_000 });
    await page.getByText(/^Off by [\d.]+ mm \(\w+\) on frames that it never saw\./).waitFor();
    await page.getByRole('link', { name: 'Why this verdict' }).waitFor();
    await page.getByText(/^[\d.]+ mm \(\w+\) on frames that it was not fitted to\./).waitFor();
    await page.getByRole('img', { name: 'The twin' }).waitFor();
    const ofLosses = page.locator('section', { has: page.getByRole('heading', { name: 'Losses' }) });
    await expect.poll(() => ofLosses.locator('.chart').count()).toBe(2);
    await page
      .getByRole('cell', { name: 'bending 2/2' })
      .or(page.getByRole('rowheader', { name: 'bending 2/2' }))
      .first()
      .waitFor();
    await page.getByText('Stiffness of springs').waitFor();
    await visit.stop('fit-done');
    await visit.close();
  });

  it('go on being watched after the server was killed', async () => {
    const settings = { effort: 'draft', graph: { max_nodes: 20 }, refine: { passes: 120 } };
    const body = { capture, display_name: 'interrupted', settings };
    const { name } = await call<{ name: string }>(server, 'POST', '/v1/fits', body);
    const visit = await Visit.open(browser, server, { at: `/${name}` });
    visit.allow(/ERR_CONNECTION|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE|ERR_FAILED/);
    const bar = visit.page.getByRole('region', { name: 'Fit', exact: true }).getByRole('progressbar');
    await expect.poll(async () => Number(await bar.getAttribute('value')), { timeout: 600_000 }).toBeGreaterThan(0.1);
    await server.kill();
    await visit.page.getByText('The server does not answer').waitFor();
    await server.start();
    await visit.page.getByRole('link', { name: 'Play with the twin' }).waitFor({ timeout: 600_000 });
    await visit.stop('fit-after-kill');
    await visit.close();
    await call(server, 'DELETE', `/v1/${name}`);
    const { twins } = await call<{ twins: { name: string }[] }>(server, 'GET', '/v1/twins?order_by=create_time desc');
    await call(server, 'DELETE', `/v1/${twins[0]?.name ?? ''}`);
  });

  it('can be cancelled, also while they wait', async () => {
    const queued = (display_name: string): Promise<{ name: string }> =>
      call(server, 'POST', '/v1/fits', { capture, display_name, settings: { refine: { passes: 100_000 } } });
    // One after the other, for the one that comes first runs.
    const first = await queued('long');
    const second = await queued('waiting');
    const running = async (): Promise<boolean> =>
      (await call<{ job: { state: string } }>(server, 'GET', `/v1/${first.name}`)).job.state === 'RUNNING';
    await until(running);
    const visit = await Visit.open(browser, server, { at: `/${second.name}` });
    const { page } = visit;
    await page.getByText('Waits its turn: the only one is busy.').waitFor();
    const watched = await Visit.open(browser, server, { at: `/${first.name}` });
    await watched.page.getByText(/^Now [\d.]+ mm/).waitFor();
    await visit.stop('fit-queued');
    await visit.go('/fits');
    for (const name of ['long', 'waiting']) await page.getByRole('checkbox', { name: `Select ${name}` }).check();
    await page.getByText('2 fits selected').waitFor();
    await visit.stop('fits-selected');
    // Cancelling asks first, as deleting does.
    const question = page.getByRole('dialog', { name: 'Cancel 2 fits?' });
    await page.getByRole('button', { name: 'Cancel' }).click();
    await question.getByRole('button', { name: 'Keep them' }).click();
    await question.waitFor({ state: 'detached' });
    expect(await running()).toBe(true);
    await page.getByRole('button', { name: 'Cancel' }).click();
    await visit.stop('fits-cancel');
    await question.getByRole('button', { name: 'Cancel the fits' }).click();
    await expect.poll(() => page.getByRole('row').getByText('cancelled').count()).toBe(2);
    await watched.page.getByText(/^When it ended [\d.]+ mm \(\w+\) on the frames that it was being fitted to/).waitFor();
    await watched.close();
    await page.getByRole('checkbox', { name: 'Select waiting' }).uncheck();
    await page.getByRole('button', { name: 'Delete' }).click();
    await page.getByRole('dialog').getByRole('button', { name: 'Delete' }).click();
    await expect.poll(() => page.getByRole('link', { name: 'long' }).count()).toBe(0);
    await page.getByRole('link', { name: 'waiting' }).click();
    await visit.heading('waiting');
    await page.getByRole('button', { name: 'Delete' }).click();
    await page.getByRole('dialog').getByRole('button', { name: 'Delete' }).click();
    await visit.heading('Fits');
    await page.getByText(/^\d+ fits?$/).waitFor();
    await page.getByLabel('State').selectOption('succeeded');
    await page.getByText(/^\d+ fits? with state “\u2068succeeded\u2069”$/).waitFor();
    await visit.stop('fits');
    await visit.close();
  });

  it('are compared, twins as well as fits', async () => {
    const settings = { effort: 'draft', ...COARSE, seed: 1, search: { sigma: 0.123456, generations: 2, starts: 1 } };
    await call(server, 'POST', '/v1/fits', { capture, display_name: 'two starts', settings });
    const twins = async (): Promise<{ name: string }[]> =>
      (await call<{ twins: { name: string }[] }>(server, 'GET', '/v1/twins')).twins;
    await until(async () => (await twins()).length === 2);
    const visit = await Visit.open(browser, server, { at: '/twins' });
    const { page } = visit;
    await page.getByRole('checkbox').nth(1).waitFor();
    for (const index of [0, 1]) await page.getByRole('checkbox').nth(index).check();
    await visit.stop('twins');
    await page.getByRole('link', { name: 'Compare' }).click();
    await visit.heading('Compare twins');
    await page.getByText(/two starts \(\d\)\u2069 is better|No difference between/).waitFor();
    await page.getByRole('rowheader', { name: 'effort' }).waitFor();
    // Numbers have three digits.
    await page.getByRole('row', { name: 'search.sigma' }).getByText('0.123', { exact: true }).waitFor();
    await page.getByRole('row', { name: 'search.sigma' }).getByText('0.167', { exact: true }).waitFor();
    expect(await page.locator('.best').count()).toBeGreaterThan(0);
    await visit.stop('twins-compared');
    await visit.go('/fits');
    for (const index of [0, 1])
      await page
        .getByRole('row', { name: /two starts/ })
        .getByRole('checkbox')
        .nth(index)
        .check();
    await page.getByRole('link', { name: 'Compare 2' }).click();
    await visit.heading('Compare fits');
    await page.locator('.chart canvas').nth(1).waitFor();
    await visit.stop('fits-compared');
    await visit.close();
  });

  it('have names, notes and tags, and twins are files that come and go', async () => {
    const { twins } = await call<{ twins: { name: string }[] }>(server, 'GET', '/v1/twins');
    const visit = await Visit.open(browser, server, { at: `/${twins[0]?.name ?? ''}` });
    const { page } = visit;
    await looked(visit);
    await page.getByRole('button', { name: 'Edit name, note and tags' }).click();
    await page.getByLabel('Name', { exact: true }).fill('blue rope');
    await page.getByLabel('Note', { exact: true }).fill('two lines\nof a note');
    await page.getByLabel('Tags', { exact: true }).fill('wet, wet no<good>');
    await page.getByRole('button', { name: 'Save' }).click();
    await page.getByText('is not a tag').waitFor();
    await visit.stop('twin-edited');
    await page.getByLabel('Tags', { exact: true }).fill('wet slow');
    await page.getByRole('button', { name: 'Save' }).click();
    await visit.heading('blue rope');
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Export' }).click();
    await page.getByRole('link', { name: 'Twin file' }).click();
    const path = await (await download).path();
    await page.getByRole('link', { name: 'wet' }).click();
    await visit.heading('Twins');
    await expect.poll(() => page.getByRole('row').count()).toBe(2);
    await page
      .getByLabel('File of a twin')
      .setInputFiles({ name: 'copy.safetensors', mimeType: '', buffer: readFileSync(path) });
    await visit.heading('copy');
    await page.getByText('imported').waitFor();
    await page.getByText('Evaluate on a capture').click();
    await page.getByRole('button', { name: 'Evaluate' }).click();
    await page.getByRole('heading', { name: 'Errors' }).nth(1).waitFor();
    await visit.stop('twin-evaluated');
    await visit.close();
  });
});

/** Finds on the page of a twin what it looks like, why it is no better, its GLB, and how Python uses it. */
async function looked(visit: Visit): Promise<void> {
  const { page } = visit;
  await page.locator('.twin-picture canvas').waitFor();
  await page.locator('.verdict').getByText(/^Off by [\d.]+ mm \(tracks\) on frames/).waitFor();
  const why = page.getByRole('region', { name: 'Why this verdict' });
  await why.getByRole('row', { name: /^Size of the object [\d.]+ mm/ }).waitFor();
  await why.getByText(/^What makes it (fair|poor): /).waitFor();
  await why.getByRole('button', { name: 'Explain: Error as a share of it' }).click();
  await why.getByText('divided by the number of this row').waitFor();
  await visit.stop('twin');
  await page.keyboard.press('Escape');
  const button = page.getByRole('button', { name: 'Export' });
  await button.click();
  const glb = page.getByRole('link', { name: 'GLB' });
  expect(await glb.getAttribute('href')).toMatch(/^\/v1\/twins\/[0-9a-f-]+\/export\?format=glb$/);
  await page.keyboard.press('ArrowDown');
  expect(await glb.evaluate((link) => link === document.activeElement)).toBe(true);
  await visit.stop('twin-export');
  await page.keyboard.press('Escape');
  await glb.waitFor({ state: 'hidden' });
  expect(await button.evaluate((own) => own === document.activeElement)).toBe(true);
  await page.getByRole('button', { name: 'Use in Python' }).click();
  await page.getByRole('dialog').getByText('pip install bendtwin', { exact: true }).waitFor();
  await page.getByRole('dialog').getByText('twin = client.twin("twins/').waitFor();
  await visit.stop('twin-python');
  await page.getByRole('button', { name: 'Close' }).click();
}

/** Numbers of pixels in the blue of recorded points and in the green of predicted ones. */
function inColours({ data }: Picture): [number, number] {
  const counts: [number, number] = [0, 0];
  for (let i = 0; i < data.length; i += 4) {
    const [red, green, blue] = [data[i]!, data[i + 1]!, data[i + 2]!];
    if (blue > green + 40 && blue > red + 60) counts[0] += 1;
    if (green > red + 60 && green > blue + 20) counts[1] += 1;
  }
  return counts;
}
