import { rmSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import { BOARD, middleOf, paintBoard } from './kit/board';
import { call, folder, makeFull, sendCapture } from './kit/made';
import { camerasOf } from './kit/playback';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

/** Frames of the recording. */
const FRAMES = 20;
/** Longest wait for masks, points and a fit [ms]: a bound, not an expectation. */
const LONG = { timeout: 900_000 };
/** What a lab does not have: masks, calibration, tracks, a mesh, and the truth. */
const LACKING = ['mask', 'calibrate.pkl', 'cotracker', 'shape', 'gt_track_3d.pkl'];

type Place = readonly [column: number, row: number];

describe('from cameras to a twin', () => {
  withServer();
  let recording: string;
  /** Places of things in the first image of the first camera. */
  const places: Record<'object' | 'hand', Place> = { object: [0, 0], hand: [0, 0] };
  beforeAll(async () => {
    // The cameras see a board on the table; then all is taken away but what cameras record.
    recording = makeFull(join(folder(), 'lab'), '--raw', '--frames', String(FRAMES), 'toy');
    const whole = makeFull(join(folder(), 'whole.zip'), '--raw', '--frames', '12', 'toy');
    const page = await browser.newPage();
    await paintBoard(page, recording, await camerasOf(server, await sendCapture(server, whole, 'whole')));
    places.object = await middleOf(page, join(recording, 'mask/0/0/0.png'));
    places.hand = await middleOf(page, join(recording, 'mask/0/1/0.png'));
    await page.context().close();
    for (const name of LACKING) rmSync(join(recording, name), { recursive: true, force: true });
  });

  it('a recording of colour and depth is calibrated by a board, masked by clicks, fitted and played', async () => {
    const visit = await Visit.open(browser, server, { at: '/upload' });
    const { page } = visit;
    await page.getByLabel('Choose a folder').setInputFiles(recording);
    // What it lacks is said before it is sent.
    await page.getByText('No calibration: a board').waitFor();
    await page.getByRole('button', { name: 'Upload lab' }).click();
    await page.getByRole('link', { name: 'Open the capture' }).click();
    await visit.heading('lab');
    // The refusal leads to the form.
    await page.locator('.findings').getByText('NOT_CALIBRATED').first().waitFor(LONG);
    await page.getByText('First images').waitFor();
    await visit.stop('cameras-refused');
    await page.getByRole('button', { name: 'Calibrate with a board' }).click();
    await page.getByLabel('Squares in a row').fill(String(BOARD.columns));
    await page.getByLabel('Rows of squares').fill(String(BOARD.rows));
    await page.getByLabel('Side of a square [mm]').fill(String(1000 * BOARD.square));
    await page.getByLabel('Side of a marker [mm]').fill(String(1000 * BOARD.marker));
    await page.getByLabel('Dictionary of the markers').selectOption(BOARD.dictionary);
    await page.getByRole('button', { name: 'Calibrate', exact: true }).click();
    await expect.poll(() => page.getByText('NOT_CALIBRATED').count(), LONG).toBe(0);
    await page.locator('.findings').getByText('MASKS_MISSING').first().waitFor(LONG);
    await page.locator('summary', { hasText: /^Calibration$/ }).click();
    await page.getByText('Reprojection error').waitFor();
    await visit.stop('cameras-calibrated');
    await page.getByRole('link', { name: 'Mark the object and the hand' }).first().click();
    await visit.heading('Masks of lab');
    await visit.stop('masks-empty');
    const image = page.getByRole('application').first();
    await mark(page, places.object);
    await page.keyboard.press('2');
    await mark(page, places.hand);
    // The table with the board is neither.
    await page.keyboard.press('3');
    await mark(page, [12, 12]);
    await expect.poll(() => page.getByRole('heading', { name: '3 marks' }).count()).toBe(1);
    await visit.stop('masks-marked');
    await page.getByRole('button', { name: 'Follow', exact: true }).click();
    await page.getByRole('button', { name: 'Use these masks' }).waitFor(LONG);
    await page.getByText(/^Doubt:/).first().waitFor();
    await image.focus();
    await visit.stop('masks-followed');
    await page.getByRole('button', { name: 'Use these masks' }).click();
    await visit.heading('lab');
    await page.getByRole('link', { name: 'Start a fit' }).click(LONG);
    await page.getByRole('radio', { name: /Draft/ }).check();
    // A first look is enough here, and takes a second.
    const settings = [['search.generations', '1'], ['refine.passes', '1'], ['graph.max_nodes', '30']] as const;
    for (const [index, [name, value]] of settings.entries()) {
      await page.getByRole('button', { name: 'Add a setting' }).click();
      await page.getByLabel(`Setting ${index + 1}, name`).fill(name);
      await page.getByLabel(`Setting ${index + 1}, value`).fill(value);
    }
    await page.getByRole('button', { name: 'Start the fit' }).click();
    await page.getByRole('link', { name: 'Play with the twin' }).click(LONG);
    await page.getByText('frames/s simulated').waitFor(LONG);
    await visit.stop('cameras-twin');
    await visit.close();
  });

  it('marks are made, undone and kept by keyboard, on a small screen', async () => {
    const { captures } = await call<{ captures: { name: string; display_name: string }[] }>(server, 'GET', '/v1/captures');
    const viewport = { width: 360, height: 740 };
    const at = `/${captures.find(({ display_name }) => display_name === 'lab')!.name}/masks`;
    const visit = await Visit.open(browser, server, { at, viewport, colorScheme: 'dark', hasTouch: true });
    const { page } = visit;
    const image = page.getByRole('application').first();
    await image.focus();
    const marks = (): Promise<number> => page.locator('.masks-strokes li').count();
    const before = await marks();
    await page.keyboard.press('2');
    for (const key of ['ArrowLeft', 'Shift+ArrowUp', 'Enter', 'Alt+Enter']) await page.keyboard.press(key);
    await expect.poll(marks).toBe(before + 2);
    expect(await page.locator('.masks-strokes li').first().innerText()).toContain('Background');
    await page.keyboard.press('Control+z');
    await expect.poll(marks).toBe(before + 1);
    await image.tap({ position: { x: 30, y: 30 } });
    await expect.poll(marks).toBe(before + 2);
    await page.keyboard.press('+');
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(360);
    await visit.stop('masks-small');
    await page.reload();
    await expect.poll(marks).toBe(before + 2);
    await page.getByRole('button', { name: /^Remove: Hand/ }).last().click();
    await expect.poll(marks).toBe(before + 1);
    await visit.close();
  });
});

/** Clicks a pixel of the first camera's image. */
async function mark(page: Page, [column, row]: Place): Promise<void> {
  const image = page.getByRole('application').first();
  const box = await image.boundingBox();
  const size = await image.evaluate((canvas) => (canvas as HTMLElement).style.aspectRatio.split('/').map(Number));
  const [columns = 1, rows = 1] = size;
  const position = { x: ((column + 0.5) / columns) * box!.width, y: ((row + 0.5) / rows) * box!.height };
  await image.click({ position });
}
