import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import type { BrowserContextOptions, Page } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import { TwinFile } from '../../src/embed/file';
import { barriers } from '../kit/barriers';
import { exportPage } from './export';
import { folder } from '../kit/made';
import { changed, colourAt, mean, pictureOf, type Colour, type Picture } from '../kit/pixels';
import { fitted } from '../kit/rope';
import { browser, server, withServer } from '../kit/server';
import { SCREENSHOTS } from '../kit/visit';

/** Difference of the channels from which on a pixel is of the object: page, ground and shadow are grey. */
const COLOURFUL = 40;
/** Least number of pixels that the object covers. */
const COVERED = 3000;
/** Distance of two colours without their brightness, of which each sums to 1. */
const ALIKE = 0.06;

let page: string;
let twinFile: Buffer;

describe('the web page of a twin, opened from a file', () => {
  withServer();
  beforeAll(async () => {
    const { twin } = await fitted(server, 'Toy <b>&amp;', ['toy', '--raw', '--tiny']);
    ({ page, file: twinFile } = await exportPage(server, `twins/${twin}`, folder()));
  });

  it('shows the object in its colours, and asks for nothing', async () => {
    const { visit, faults, requests } = await open(page);
    expect(await visit.title()).toBe('Toy <b>&amp;');
    await visit.getByText('Toy <b>&amp;', { exact: true }).waitFor();
    const { picture, pixels } = await seen(visit);
    expect(pixels.length).toBeGreaterThan(COVERED);
    const own = share(meanColour(new TwinFile(new Uint8Array(twinFile)).bytes('surface.color')));
    share(mean(picture, pixels)).forEach((part, k) => expect(Math.abs(part - own[k]!)).toBeLessThan(ALIKE));
    expect(Buffer.from((await visit.locator('#twin').textContent())!, 'base64').equals(twinFile)).toBe(true);
    await stop(visit, 'embed', faults);
    expect(requests).toEqual([pathToFileURL(page).href]);
  });

  it('is pulled with the mouse, and let go', async () => {
    const { visit, faults } = await open(page);
    const still = await seen(visit);
    const [x, y] = middleOf(still.picture, still.pixels);
    await visit.mouse.move(x, y);
    await visit.mouse.down();
    // It follows while the pointer moves, not only when that rests.
    for (let step = 1; step <= 60; step += 1) {
      await visit.mouse.move(x - 2 * step, y - 3 * step);
      await visit.waitForTimeout(25);
    }
    // Part of the object hangs at a hand.
    await expect.poll(async () => up(still, await seen(visit))).toBeGreaterThan(10);
    await stop(visit, 'embed-pulled', faults);
    await visit.mouse.up();
    await expect.poll(async () => up(still, await seen(visit))).toBeLessThan(7);
    await visit.getByRole('button', { name: 'Let go' }).click();
    await visit.getByRole('button', { name: 'Hold' }).waitFor();
    await expect.poll(async () => up(still, await seen(visit))).toBeLessThan(-3);
    await visit.getByRole('button', { name: 'Reset' }).click();
    await visit.getByRole('button', { name: 'Let go' }).waitFor();
    expect(faults).toEqual([]);
  });

  it('is worked by keys', async () => {
    const { visit, faults } = await open(page, { reducedMotion: 'reduce' });
    // Nothing moves by itself where that is not wanted.
    await visit.getByText('Paused').waitFor();
    const still = await seen(visit);
    await visit.keyboard.press('Tab');
    await visit.keyboard.press('ArrowLeft');
    await visit.keyboard.press('ArrowLeft');
    expect(changed(still.picture, await pictureOf(visit), 40).length).toBeGreaterThan(COVERED / 4);
    await visit.keyboard.press('Space');
    await visit.getByRole('button', { name: 'Pause' }).waitFor();
    const turned = await seen(visit);
    await visit.keyboard.down('Shift');
    await visit.keyboard.down('ArrowUp');
    await expect.poll(async () => up(turned, await seen(visit))).toBeGreaterThan(6);
    await visit.keyboard.up('ArrowUp');
    await visit.keyboard.up('Shift');
    await visit.keyboard.press('Space');
    await visit.getByRole('button', { name: 'Play' }).waitFor();
    await visit.keyboard.press('r');
    await visit.getByText('Reset', { exact: true }).first().waitFor();
    expect(faults).toEqual([]);
  });

  it('fits a phone, a dark page and a frame of another page', async () => {
    const phone = await open(page, { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
    expect((await seen(phone.visit)).pixels.length).toBeGreaterThan(COVERED / 4);
    await stop(phone.visit, 'embed-phone', phone.faults);
    const dark = await open(page, { colorScheme: 'dark', viewport: { width: 1440, height: 900 } });
    await seen(dark.visit);
    await stop(dark.visit, 'embed-dark', dark.faults);
    const outer = join(folder(), 'outer.html');
    writeFileSync(outer, `<title>Outer</title><iframe title="Toy" sandbox="allow-scripts" width="600" height="400" src="${pathToFileURL(page).href}"></iframe>`);
    const framed = await open(outer);
    await framed.visit.frameLocator('iframe').getByRole('button', { name: 'Reset' }).waitFor();
    const area = { x: 10, y: 10, width: 580, height: 380 };
    await expect.poll(async () => colourful(await pictureOf(framed.visit, area)).length).toBeGreaterThan(COVERED / 4);
    expect(framed.faults).toEqual([]);
  });

  it('says what is wrong with a file that it cannot show', async () => {
    const broken = join(folder(), 'broken.html');
    writeFileSync(broken, readFileSync(page, 'utf8').replace(twinFile.toString('base64'), 'AAAA'));
    const { visit } = await open(broken);
    await visit.getByRole('alert').waitFor();
    expect(await visit.getByRole('heading').textContent()).toBe('Toy <b>&amp;');
  });
});

/** Opens a file in a browser without a network; gives its page, errors, and requests, which there should be none of. */
async function open(path: string, options: BrowserContextOptions = {}): Promise<{ visit: Page; faults: string[]; requests: string[] }> {
  const context = await browser.newContext({ viewport: { width: 900, height: 600 }, offline: true, ...options });
  const [faults, requests] = [[] as string[], [] as string[]];
  const visit = await context.newPage();
  visit.on('pageerror', (error) => faults.push(error.message));
  visit.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
  visit.on('request', (request) => requests.push(request.url()));
  await visit.goto(pathToFileURL(path).href);
  return { visit, faults, requests };
}

async function stop(visit: Page, name: string, faults: readonly string[]): Promise<void> {
  mkdirSync(SCREENSHOTS, { recursive: true });
  await visit.screenshot({ path: `${SCREENSHOTS}${name}.png` });
  expect(await barriers(visit), `accessibility of ${name}`).toEqual([]);
  expect(faults, `errors of the page up to ${name}`).toEqual([]);
}

interface Seen {
  readonly picture: Picture;
  /** Pixels of the object. */
  readonly pixels: number[];
}

/** The picture, and its pixels of the object, once it is drawn. */
async function seen(visit: Page): Promise<Seen> {
  let found: Seen = { picture: await pictureOf(visit), pixels: [] };
  await expect.poll(async () => {
    const picture = await pictureOf(visit);
    found = { picture, pixels: colourful(picture) };
    return found.pixels.length;
  }).toBeGreaterThan(0);
  return found;
}

function colourful(picture: Picture): number[] {
  return Array.from({ length: picture.width * picture.height }, (_, i) => i).filter((i) => {
    const colour = colourAt(picture, i);
    return Math.max(...colour) - Math.min(...colour) > COLOURFUL;
  });
}

/** Pixels by which the object is higher in a picture than in another. */
function up(before: Seen, now: Seen): number {
  return middleOf(before.picture, before.pixels)[1] - middleOf(now.picture, now.pixels)[1];
}

function middleOf(picture: Picture, pixels: readonly number[]): [number, number] {
  let [x, y] = [0, 0];
  for (const pixel of pixels) [x, y] = [x + (pixel % picture.width), y + Math.floor(pixel / picture.width)];
  return [x / pixels.length, y / pixels.length];
}

function meanColour(bytes: Uint8Array): Colour {
  const sum = [0, 0, 0];
  bytes.forEach((value, i) => (sum[i % 3]! += value));
  return sum as unknown as Colour;
}

/** A colour without its brightness. */
function share([r, g, b]: Colour): Colour {
  const all = r + g + b;
  return [r / all, g / all, b / all];
}
