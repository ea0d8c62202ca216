import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import { Server } from '../scripts/server.mjs';
import { folder, makeCapture, makeTwo, sendCapture } from './kit/made';
import { COARSE, twinOf } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('the playback', () => {
  withServer();
  let capture: string;
  let twin: string;
  beforeAll(async () => {
    const made = makeCapture(join(folder(), 'toy.zip'), 'toy', '--raw');
    const name = await sendCapture(server, made, 'a toy');
    capture = name.replace('captures/', '');
    twin = await twinOf(server, name, 'a toy', COARSE);
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
    // All cameras at this moment, one of them large.
    const other = page.getByRole('button', { name: 'Camera made1' });
    for (const index of [0, 1]) await expect.poll(() => isDrawn(page, '.playback-thumbnail', index)).toBe(true);
    await page.keyboard.press('2');
    await page.getByText('Camera made1').waitFor();
    expect(await other.getAttribute('aria-pressed')).toBe('true');
    await expect.poll(() => page.url()).toContain('camera=1');
    await page.getByRole('button', { name: 'Camera made0' }).click();
    expect(await other.getAttribute('aria-pressed')).toBe('false');
    await page.keyboard.press('2');
    await expect.poll(() => isDrawn(page)).toBe(true);
    await visit.stop('playback');
    await page.reload();
    await visit.heading('Playback of a toy');
    expect(await time(page)).toContain('frame 7 of 19');
    await page.getByText('Camera made1').waitFor();
    await visit.close();
  });

  it('shows the prediction of the best twin with the error of every frame', async () => {
    const at = `/captures/${capture}/playback?frame=16`;
    const visit = await Visit.open(browser, server, { at, viewport: { width: 1440, height: 900 } });
    const { page } = visit;
    await visit.heading('Playback of a toy');
    await page.getByText('Error (not fitted to this frame):').waitFor();
    const twins = page.getByRole('combobox', { name: 'Prediction of' });
    expect(await twins.inputValue()).toBe(twin);
    await expect.poll(() => page.url()).toContain(`twin=${twin}`);
    const legend = page.locator('.axis-legend');
    expect(await legend.innerText()).toMatch(/Tracks [\d.]+ mm.*\s*Surface L1 [\d.]+ mm/);
    expect(await legend.innerText()).toMatch(/Standing still \(mean: fitted [\d.]+ mm, future [\d.]+ mm\)/);
    expect(await legend.innerText()).toMatch(/Hand [\d.]+ m\/s/);
    // The large image and the picture in three dimensions fill the width and the same height.
    const [stage, cameras] = await Promise.all(['.stage', '.playback-cameras'].map((part) => page.locator(part).boundingBox()));
    expect(cameras!.x + cameras!.width - stage!.x).toBeGreaterThan(1390);
    expect(Math.abs(stage!.height - cameras!.height)).toBeLessThan(4);
    await visit.stop('playback-twin');
    // The worst frame is a click away, with its error.
    const worst = page.getByRole('button', { name: /^Worst frame/ });
    const error = /[\d.]+ mm/.exec(await worst.innerText())![0];
    await worst.click();
    await expect.poll(() => legend.innerText()).toContain(`Tracks ${error}`);
    await page.getByRole('checkbox', { name: 'Side by side' }).check();
    await page.getByRole('combobox', { name: 'Colour of points' }).selectOption('error');
    await page.getByText('Distance to the prediction').waitFor();
    await expect.poll(() => page.url()).toContain('beside=1');
    await visit.stop('playback-beside');
    const strip = (await page.locator('.axis-strip').boundingBox())!;
    await page.mouse.move(strip.x + 2, strip.y + 40);
    await page.mouse.down();
    expect(await time(page)).toContain('frame 0 of 19');
    await page.mouse.move(strip.x + strip.width - 2, strip.y + strip.height - 5);
    expect(await time(page)).toContain('frame 19 of 19');
    await page.mouse.up();
    await page.getByRole('button', { name: 'Full screen' }).click();
    await expect.poll(() => page.evaluate(() => document.fullscreenElement?.className)).toContain('playback');
    await page.getByRole('button', { name: 'Full screen' }).click();
    await expect.poll(() => page.evaluate(() => document.fullscreenElement)).toBeNull();
    await twins.selectOption('no twin');
    await expect.poll(() => page.url()).toContain('twin=none');
    await page.locator('.axis-errors').waitFor({ state: 'detached' });
    await page.getByText('Speed:').waitFor();
    expect(await twins.inputValue()).toBe('none');
    await visit.close();
  });

  it('of several recordings leads to the worst frame of all', async () => {
    const several = await sendCapture(server, await makeTwo(folder()), 'two takes');
    await twinOf(server, several, 'of two', COARSE);
    const visit = await Visit.open(browser, server, { at: `/${several}/playback`, viewport: { width: 1440, height: 900 } });
    const { page } = visit;
    const legend = page.locator('.axis-legend');
    const errors: number[] = [];
    const worst = page.getByRole('button', { name: /^Worst frame of this sequence/ });
    for (const index of [0, 1]) {
      await visit.go(`/${several}/playback?sequence=${index}`);
      await page.reload();
      errors.push(Number(/([\d.]+) mm/.exec(await worst.innerText())?.[1]));
    }
    const largest = errors[0]! > errors[1]! ? 0 : 1;
    await page.getByRole('button', { name: 'Worst frame of all 2 sequences' }).click();
    await expect.poll(() => legend.innerText()).toContain(`Tracks ${errors[largest]} mm`);
    expect(await page.getByRole('combobox', { name: 'Sequence' }).inputValue()).toBe(String(largest));
    await visit.stop('playback-worst');
    await visit.close();
  });

  it('makes a video of the prediction beside the recording', async () => {
    const visit = await Visit.open(browser, server, { at: `/captures/${capture}/playback?frame=5&twin=${twin}` });
    const { page } = visit;
    await page.getByText('Error (fitted to this frame):').waitFor();
    const button = page.getByRole('button', { name: 'Video' });
    await button.click();
    await page.getByRole('dialog').getByText(/of 20 frames/).waitFor();
    await page.getByRole('button', { name: 'Cancel' }).click();
    await page.getByText('The video was given up.').waitFor();
    expect(await time(page)).toContain('frame 5 of 19');
    const [download] = await Promise.all([page.waitForEvent('download'), button.click()]);
    expect(download.suggestedFilename()).toBe('a-toy.webm');
    const { seconds, width, height } = await filmOf(page, await download.path());
    expect(seconds).toBeCloseTo(20 / 30, 1);
    expect(width).toBeGreaterThan(1.5 * height);
    await page.getByText('The video is in your downloads.').waitFor();
    expect(await time(page)).toContain('frame 5 of 19');
    await visit.stop('playback-video');
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

/** Length and size of a video [s, pixels], as the browser plays it. */
async function filmOf(page: Page, path: string): Promise<{ seconds: number; width: number; height: number }> {
  const blank = await page.context().newPage();
  const film = await blank.evaluate(async (address) => {
    const video = document.createElement('video');
    video.src = address;
    await new Promise((resolve, reject) => {
      video.addEventListener('loadeddata', resolve);
      video.addEventListener('error', () => reject(new Error(video.error?.message)));
    });
    return { seconds: video.duration, width: video.videoWidth, height: video.videoHeight };
  }, `data:video/webm;base64,${readFileSync(path).toString('base64')}`);
  await blank.close();
  return film;
}

/** True if an image of a camera, the large one unless it is said otherwise, has more than one colour. */
function isDrawn(page: Page, place = '.playback-camera', index = 0): Promise<boolean> {
  return page.locator(`${place} canvas`).nth(index).evaluate((canvas) => {
    const { width, height } = canvas as HTMLCanvasElement;
    const data = (canvas as HTMLCanvasElement).getContext('2d')!.getImageData(0, 0, width, height).data;
    return data.some((value, i) => i > 4 && value !== data[i % 4]);
  });
}
