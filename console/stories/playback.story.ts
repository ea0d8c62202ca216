import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import { Server } from '../scripts/server.mjs';
import { call, folder, makeCapture, sendCapture, until } from './kit/made';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

/** Settings with which a fit takes seconds. */
const QUICK = { search: { generations: 1 }, refine: { passes: 1 } };

interface Fit {
  readonly name: string;
  readonly twin: string | null;
}

describe('the playback', () => {
  withServer();
  let capture: string;
  let twin: string;
  beforeAll(async () => {
    const made = makeCapture(join(folder(), 'toy.zip'), 'toy', '--raw');
    const name = await sendCapture(server, made, 'a toy');
    capture = name.replace('captures/', '');
    const fit = await call<Fit>(server, 'POST', '/v1/fits', { capture: name, settings: QUICK });
    await until(async () => (await call<Fit>(server, 'GET', `/v1/${fit.name}`)).twin !== null);
    twin = (await call<Fit>(server, 'GET', `/v1/${fit.name}`)).twin!.replace('twins/', '');
  });

  const time = (page: Page): Promise<string> => page.locator('.playback-time').innerText();

  it('shows points and what cameras saw, frame by frame, and links to a moment', async () => {
    const visit = await Visit.open(browser, server, { at: `/captures/${capture}` });
    const { page } = visit;
    await page.getByRole('link', { name: 'Play the recording' }).click();
    await visit.heading('Playback of a toy');
    await page.getByText('Camera made0').waitFor();
    await expect.poll(() => isDrawn(page)).toBe(true);
    expect(await time(page)).toContain('frame 0 of 19');
    await page.getByRole('button', { name: 'Play', exact: true }).click();
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    // It stops at the end by itself.
    await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
    expect(await time(page)).toContain('frame 19 of 19');
    await page.getByRole('button', { name: 'Frame before' }).click();
    await page.getByRole('slider', { name: 'Frame' }).fill('7');
    expect(await time(page)).toContain('frame 7 of 19, 0.23 s, for fitting');
    await expect.poll(() => page.url()).toContain('frame=7');
    await page.getByRole('combobox', { name: 'Camera' }).selectOption({ index: 1 });
    await expect.poll(() => page.url()).toContain('camera=1');
    await expect.poll(() => isDrawn(page)).toBe(true);
    await visit.stop('playback');
    await page.reload();
    await visit.heading('Playback of a toy');
    expect(await time(page)).toContain('frame 7 of 19');
    await visit.close();
  });

  it('shows the prediction of a twin with the error of every frame', async () => {
    const visit = await Visit.open(browser, server, { at: `/captures/${capture}/playback?frame=16` });
    const { page } = visit;
    await visit.heading('Playback of a toy');
    await page.getByRole('combobox', { name: 'Prediction of' }).selectOption(twin);
    await page.getByText('Error (not fitted to this frame):').waitFor();
    expect(await page.locator('.playback-errors').innerText()).toMatch(/Tracks [\d.]+ mm\s*Surface L1 [\d.]+ mm/);
    await visit.stop('playback-twin');
    await page.getByRole('checkbox', { name: 'Side by side' }).check();
    await page.getByRole('combobox', { name: 'Colour of points' }).selectOption('error');
    await page.getByText('Distance to the prediction').waitFor();
    await expect.poll(() => page.url()).toContain('beside=1');
    await visit.stop('playback-beside');
    await page.locator('.playback-chart-canvas').click({ position: { x: 2, y: 40 } });
    expect(await time(page)).toContain('frame 0 of 19');
    await visit.close();
  });

  it('can be used with the keyboard alone, on a small screen', async () => {
    const viewport = { width: 360, height: 740 };
    const at = `/captures/${capture}/playback?twin=${twin}`;
    const visit = await Visit.open(browser, server, { at, viewport, colorScheme: 'dark' });
    const { page } = visit;
    await page.getByText('Error (fitted to this frame):').waitFor();
    await page.keyboard.press('.');
    await page.keyboard.press('.');
    await page.keyboard.press(',');
    expect(await time(page)).toContain('frame 1 of 19');
    await page.getByRole('slider', { name: 'Frame' }).focus();
    await page.keyboard.press('ArrowRight');
    expect(await time(page)).toContain('frame 2 of 19');
    await page.getByRole('heading', { level: 1 }).click();
    await page.keyboard.press('Space');
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    await page.keyboard.press('Space');
    await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(360);
    await visit.stop('playback-small');
    await visit.close();
  });

  it('of points that were tracked already has no images', async () => {
    const rope = await sendCapture(server, makeCapture(join(folder(), 'rope.zip'), 'rope'), '<b>rope</b>');
    const visit = await Visit.open(browser, server, { at: `/${rope}/playback` });
    await visit.heading('Playback of <b>rope</b>');
    await visit.page.getByText('40 points').first().waitFor();
    await expect.poll(() => time(visit.page)).toContain('frame 0 of');
    expect(await visit.page.locator('.playback-camera').count()).toBe(0);
    await visit.stop('playback-tracked');
    await visit.close();
  });

  it('that is not there yet says what makes it', async () => {
    const idle = await Server.start(['--client-token', 'none', '--workers', '0']);
    const headers = { 'content-type': 'application/zip' };
    const answer = await fetch(`${idle.url}/v1/captures`, { method: 'POST', body: 'no archive', headers });
    const { name } = (await answer.json()) as { name: string };
    const visit = await Visit.open(browser, idle, { at: `/${name}/playback` });
    visit.allow(/404/);
    await visit.page.getByText('PLAYBACK_MISSING').waitFor();
    await visit.page.getByRole('link', { name: 'To the capture' }).waitFor();
    await visit.close();
    await idle.remove();
  });
});

/** True if the image of the camera has more than one colour. */
function isDrawn(page: Page): Promise<boolean> {
  return page.locator('.playback-camera canvas').evaluate((canvas) => {
    const { width, height } = canvas as HTMLCanvasElement;
    const data = (canvas as HTMLCanvasElement).getContext('2d')!.getImageData(0, 0, width, height).data;
    return data.some((value, i) => i > 4 && value !== data[i % 4]);
  });
}
