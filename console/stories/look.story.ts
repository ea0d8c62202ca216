import { join } from 'node:path';
import type { Locator } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import { Server } from '../scripts/server.mjs';
import type { Api } from '../src/api/client';
import { loadAppearance } from '../src/view3d/appearance';
import { lift } from './kit/drag';
import { folder, makeCapture, sendCapture } from './kit/made';
import { changed, distance, mean, meanRow, settled, type Colour, type Picture } from './kit/pixels';
import { COARSE, twinOf } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

/** Settings with which a fit with Gaussians takes seconds, and their number grows once. */
const SPLATS = { ...COARSE, appearance: { gaussians: 3000, steps: 300 } };
/** Least number of pixels that a twin covers. */
const COVERED = 5000;
/** Distance from what is behind at which a pixel belongs to the twin: at outlines both are blended. */
const OPAQUE = 60;
/** Largest distance of mean colours that are alike. */
const ALIKE = 45;

describe('the look of a twin', () => {
  withServer();
  let capture: string;
  let twin: string;
  /** Mean colour of its splats. */
  let own: Colour;
  beforeAll(async () => {
    capture = await sendCapture(server, makeCapture(join(folder(), 'toy.zip'), 'toy', '--raw'), 'a toy');
    twin = await twinOf(server, capture, 'a toy', SPLATS);
    own = await colourOf(server, twin);
  });

  it('is that of the object', async () => {
    const visit = await Visit.open(browser, server, { at: `/twins/${twin}/view` });
    const { page } = visit;
    await page.getByText(/^[\d,]+ splats$/).waitFor();
    expect(await page.getByRole('checkbox', { name: 'Springs' }).isChecked()).toBe(false);
    await visit.stop('look');
    const { picture, pixels } = await covered(visit, page.getByRole('checkbox', { name: 'Skin' }));
    expect(pixels.length).toBeGreaterThan(COVERED);
    expect(distance(mean(picture, pixels), own)).toBeLessThan(ALIKE);
    await page.getByRole('checkbox', { name: 'Appearance' }).uncheck();
    await page.locator('.splat-count').waitFor({ state: 'hidden' });
    expect(distance(mean(await settled(page), pixels), own)).toBeGreaterThan(1.5 * ALIKE);
    await visit.close();
  });

  it('moves with what is dragged', async () => {
    const visit = await Visit.open(browser, server, { at: `/twins/${twin}/play` });
    const { page } = visit;
    await page.getByText('frames/s simulated').waitFor();
    await page.locator('.splat-count').waitFor();
    await page.getByText('Picture', { exact: true }).first().click();
    const seen = async (): Promise<{ row: number; colour: Colour }> => {
      await page.getByRole('button', { name: 'Pause', exact: true }).click();
      const { picture, pixels } = await covered(visit, page.getByRole('checkbox', { name: 'Skin' }));
      await page.getByRole('button', { name: 'Pause', exact: true }).click();
      return { row: meanRow(picture, pixels), colour: mean(picture, pixels) };
    };
    const before = await seen();
    await lift(page);
    let after = before;
    await expect.poll(async () => before.row - (after = await seen()).row).toBeGreaterThan(60);
    expect(distance(after.colour, own)).toBeLessThan(ALIKE);
    await visit.stop('look-dragged');
    await visit.close();
  });

  it('is that of its surface in an image of the recording, until the view is turned', async () => {
    const visit = await Visit.open(browser, server, { at: `/twins/${twin}/view?layers=skin,shadow` });
    const { page } = visit;
    await page.getByText('Background', { exact: true }).click();
    const background = page.getByRole('combobox', { name: 'Background' });
    const ofCamera = background.locator('option[value="camera-0"]');
    await ofCamera.waitFor({ state: 'attached' });
    const before = await settled(page);
    await background.selectOption('camera-0');
    await expect.poll(() => page.locator('.ground-scale').isVisible()).toBe(false);
    const image = await settled(page);
    expect(changed(before, image, 30).length).toBeGreaterThan(0.5 * image.width * image.height);
    await visit.stop('look-photograph');
    // The address names the image.
    await page.getByRole('button', { name: 'Copy link' }).click();
    expect(page.url()).toContain('background=camera-0');
    await page.reload();
    await page.locator('canvas').waitFor();
    await expect.poll(async () => changed(image, await settled(page), 30).length).toBeLessThan(500);
    await page.locator('canvas').focus();
    await page.keyboard.press('ArrowLeft');
    await page.locator('.ground-scale').waitFor();
    // The panel is folded since the page was loaded again.
    await expect.poll(() => page.locator('select[aria-label="Background"]').inputValue()).toBe('grid');
    await visit.close();
  });

  it('is played back beside the recording', async () => {
    const at = `/${capture}/playback?frame=2&twin=${twin}&springs=0&observed=0&controls=0`;
    const visit = await Visit.open(browser, server, { at });
    const { page } = visit;
    await page.getByText('Error (fitted to this frame):').waitFor();
    await page.locator('.splat-count').waitFor();
    await visit.stop('look-playback');
    const prediction = page.getByRole('checkbox', { name: 'Prediction' });
    const early = await covered(visit, prediction);
    expect(early.pixels.length).toBeGreaterThan(COVERED / 5);
    expect(distance(mean(early.picture, early.pixels), own)).toBeLessThan(ALIKE);
    await page.getByRole('slider', { name: 'Frame' }).fill('17');
    await page.getByText('Error (not fitted to this frame):').waitFor();
    const late = await covered(visit, prediction);
    expect(distance(mean(late.picture, late.pixels), own)).toBeLessThan(ALIKE);
    expect(Math.abs(meanRow(late.picture, late.pixels) - meanRow(early.picture, early.pixels))).toBeGreaterThan(5);
    await visit.close();
  });
});

/** The picture, and the pixels of it that a box switches. */
async function covered({ page }: Visit, box: Locator): Promise<{ picture: Picture; pixels: number[] }> {
  const picture = await settled(page);
  await box.uncheck();
  const pixels = changed(picture, await settled(page), OPAQUE);
  await box.check();
  return { picture, pixels };
}

/** Mean colour of a twin's splats, by their size and opacity. */
async function colourOf(server: Server, twin: string): Promise<Colour> {
  const api = { fetch: (path: string, init: RequestInit) => fetch(server.url + path, init) } as unknown as Api;
  const appearance = await loadAppearance(api, twin, new AbortController().signal);
  const { scales, opacities, colours } = appearance!.splats!;
  const sum = [0, 0, 0];
  let whole = 0;
  opacities.forEach((opacity, g) => {
    const [, b, c] = Array.from(scales.subarray(3 * g, 3 * g + 3)).sort((one, other) => one - other);
    const weight = opacity * b! * c!;
    whole += weight;
    sum.forEach((_, k) => (sum[k]! += 255 * weight * colours[3 * g + k]!));
  });
  return sum.map((value) => value / whole) as unknown as Colour;
}
