import { openTwinFile } from '@bendtwin/client';
import { readFileSync } from 'node:fs';
import type { Download, Page } from 'playwright-core';
import { beforeAll, describe, expect, it } from 'vitest';
import type { Api } from '../src/api/client';
import { lift, middle } from './kit/drag';
import { changed, distance, mean, settled, type Colour } from './kit/pixels';
import { QUICK, fittedRope } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit, type VisitOptions } from './kit/visit';

describe('the playground', () => {
  withServer();
  let twin: string;
  beforeAll(async () => {
    twin = await fittedRope(server, 'blue rope', QUICK);
  });

  async function play(options: VisitOptions = {}): Promise<Visit> {
    const visit = await Visit.open(browser, server, { ...options, at: `/twins/${twin}/play` });
    await visit.heading('blue rope');
    await visit.page.getByText('frames/s simulated').waitFor();
    return visit;
  }

  it('lets one drag the rope immediately, and drop it', async () => {
    const visit = await play();
    const { page } = visit;
    await page.getByText('Drag the object or a gripper').waitFor();
    await visit.stop('play');
    const [x, y] = await middle(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.getByText('Pointer 1 holds').waitFor();
    await page.mouse.move(x + 20, y - 150, { steps: 20 });
    // The pointer pulls at the object: there is an arrow with a number.
    await page.locator('.force-labels span').first().waitFor();
    // It is stretched more than when it was recorded, which is seen and said.
    await page.getByText(/^Stretched [\d.]+ times beyond anything recorded.*: do not trust this\.$/).first().waitFor();
    await page.getByText('beyond anything recorded', { exact: true }).waitFor();
    await visit.stop('play-grasp');
    expect(await page.getByText('Drag the object or a gripper').isVisible()).toBe(false);
    await page.mouse.up();
    await page.getByText('Pointer 1 holds').waitFor({ state: 'hidden' });
    await page.getByRole('button', { name: 'Drop: Hand 1' }).click();
    await page.getByRole('button', { name: 'Grasp: Hand 1' }).waitFor();
    await visit.stop('play-dropped');
    await page.getByRole('button', { name: 'Start again' }).click();
    await page.getByRole('button', { name: 'Drop: Hand 1' }).waitFor();
    await visit.close();
  });

  it('can be played with the keyboard alone', async () => {
    const visit = await play();
    const { page } = visit;
    await page.locator('canvas').focus();
    const selected = (): Promise<string> =>
      page.locator('.gripper:has(input:checked)').first().innerText();
    await expect.poll(selected).toContain('Hand 1');
    const before = await link(page);
    await page.locator('canvas').focus();
    await page.keyboard.down('PageUp');
    await expect.poll(() => page.locator('.force-labels span').count()).toBeGreaterThan(0);
    await page.waitForTimeout(400);
    await page.keyboard.up('PageUp');
    await expect.poll(() => link(page)).not.toBe(before);
    await page.locator('canvas').focus();
    for (let presses = 0; presses < 12 && !(await selected()).includes('Pointer 1'); presses += 1) {
      await page.keyboard.press('Tab');
    }
    expect(await selected()).toContain('Pointer 1');
    await page.keyboard.press('Space');
    await page.getByText('Pointer 1 holds').waitFor();
    await page.keyboard.press('Space');
    await page.getByText('Pointer 1 holds').waitFor({ state: 'hidden' });
    // The picture is no trap: Tab leads out of it after the last gripper.
    for (let presses = 0; presses < 6; presses += 1) await page.keyboard.press('Tab');
    expect(await page.evaluate(() => document.activeElement?.tagName)).not.toBe('CANVAS');
    await visit.close();
  });

  it('can be played with a finger', async () => {
    const visit = await play({ hasTouch: true, viewport: { width: 400, height: 800 } });
    const { page } = visit;
    const [x, y] = await middle(page);
    const session = await page.context().newCDPSession(page);
    const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', at: number[][]): Promise<unknown> =>
      session.send('Input.dispatchTouchEvent', { type, touchPoints: at.map(([px, py]) => ({ x: px!, y: py! })) });
    await touch('touchStart', [[x, y]]);
    await page.getByText('Pointer 1 holds').waitFor();
    for (let step = 1; step <= 10; step += 1) await touch('touchMove', [[x, y - 8 * step]]);
    await page.locator('.force-labels span').first().waitFor();
    await touch('touchEnd', []);
    await page.getByText('Pointer 1 holds').waitFor({ state: 'hidden' });
    await visit.close();
  });

  it('can be played with a gamepad', async () => {
    const visit = await play();
    const { page } = visit;
    const before = await link(page);
    await page.evaluate(() => {
      const pressed = (on: boolean): GamepadButton => ({ pressed: on, touched: on, value: Number(on) });
      const pad = { connected: true, axes: [0, 0, 0, -1], buttons: Array.from({ length: 17 }, () => pressed(false)) };
      Object.assign(window, { pad, pressed });
      navigator.getGamepads = () => [pad as unknown as Gamepad];
      dispatchEvent(new Event('gamepadconnected'));
    });
    await expect.poll(() => page.locator('.force-labels span').count()).toBeGreaterThan(0);
    await page.waitForTimeout(500);
    expect(await link(page)).not.toBe(before);
    const press = (button: number, on: boolean): Promise<void> =>
      page.evaluate(([b, o]) => {
        const { pad, pressed } = window as unknown as { pad: { buttons: unknown[] }; pressed(on: boolean): unknown };
        pad.buttons[b as number] = pressed(o as boolean);
      }, [button, on] as const);
    await press(0, true);
    await page.getByRole('button', { name: 'Grasp: Hand 1' }).waitFor();
    await visit.close();
  });

  it('changes the world, and says in words what the server refuses', async () => {
    const visit = await play();
    const { page } = visit;
    await page.getByText('World and material').click();
    await page.getByRole('slider', { name: 'Stiffness' }).fill('80');
    await page.getByRole('slider', { name: 'Gravity' }).fill('0');
    await page.getByText('Obstacles').click();
    await page.getByRole('button', { name: 'Put a ball in' }).click();
    await page.getByRole('button', { name: 'Put a box in' }).click();
    await page.getByText('Box 2').waitFor();
    await page.getByRole('button', { name: 'Move Ball 1 along +z' }).click();
    await page.waitForTimeout(500);
    await visit.stop('play-obstacles');
    await page.getByRole('button', { name: 'Take out Box 2' }).click();
    await page.getByText('Box 2').waitFor({ state: 'hidden' });
    await page.getByText('Goal', { exact: true }).click();
    await page.getByText('By numbers').click();
    await page.getByLabel('Node', { exact: true }).fill('0');
    for (const axis of ['x', 'y', 'z']) await page.getByLabel(`${axis} of its goal in metres`).fill('0');
    await page.getByRole('button', { name: 'Set', exact: true }).click();
    await page.getByRole('button', { name: 'Drop: Hand 1' }).click();
    await page.getByRole('button', { name: 'Grasp: Hand 1' }).waitFor();
    await page.getByRole('button', { name: 'Ask the planner' }).click();
    await page.getByText('Not done:').waitFor();
    await visit.close();
  });

  it('plans to a goal that was dragged', async () => {
    const visit = await play();
    const { page } = visit;
    await page.getByText('Goal', { exact: true }).click();
    await page.getByRole('button', { name: 'Set a goal' }).click();
    const [x, y] = await middle(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x, y - 40, { steps: 5 });
    await page.mouse.up();
    await page.getByText('The goal is set').waitFor();
    await page.getByRole('button', { name: 'Ask the planner' }).click();
    await page.getByText(/The planner is searching for a motion|On the way/).first().waitFor();
    await visit.stop('play-goal');
    await page.getByText(/Reached|Not reached/).first().waitFor({ timeout: 600_000 });
    await visit.stop('play-goal-end');
    await visit.close();
  });

  it('records what is done, shows it again and saves it', async () => {
    const visit = await play();
    const { page } = visit;
    await page.getByText('Recording', { exact: true }).click();
    await page.getByRole('button', { name: 'Record', exact: true }).click();
    const [x, y] = await middle(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y - 60, { steps: 15 });
    await page.mouse.up();
    await page.getByText(/Recording: \d\d+ frames/).waitFor();
    await page.getByRole('button', { name: 'Record', exact: true }).click();
    await page.getByText(/Recorded: \d+ frames/).waitFor();
    const json = JSON.parse(await text(page, 'Save as JSON')) as { twin: string; segments: unknown[] };
    expect([json.twin, json.segments.length > 0]).toEqual([`twins/${twin}`, true]);
    const rows = (await text(page, 'Save as CSV')).trimEnd().split('\n');
    expect(rows[0]).toContain('segment,frame,time_s,gripper');
    expect(rows.length).toBeGreaterThan(20);
    await page.getByRole('button', { name: 'Replay' }).click();
    await page.getByText(/Replaying frame/).waitFor();
    await visit.stop('play-replay');
    await page.getByText(/Recorded: \d+ frames/).waitFor();
    await visit.close();
  });

  it('can be watched', async () => {
    const visit = await play();
    const watched = await visit.page.getByRole('link', { name: 'Watch this play' }).getAttribute('href');
    const other = await Visit.open(browser, server, { at: watched?.slice(1) ?? '' });
    await other.page.getByText('You are watching').waitFor();
    await visit.page.getByText('1 watching').waitFor();
    await other.stop('play-watched');
    expect(await other.page.getByRole('button', { name: 'Record' }).count()).toBe(0);
    await visit.close();
    await other.page.getByText('The play has ended.').waitFor();
    await other.close();
  });

  it('makes links, pictures and videos of a moment', async () => {
    const visit = await play();
    const { page } = visit;
    await lift(page);
    const address = await link(page);
    expect(address).toContain('points=');
    const other = await Visit.open(browser, server, { at: address.slice(address.indexOf('#') + 1) });
    await other.page.getByText('frames/s simulated').waitFor();
    await other.close();
    const picture = await saved(page, () => page.getByRole('button', { name: 'Picture', exact: true }).click());
    expect(readFileSync(await picture.path()).subarray(1, 4).toString()).toBe('PNG');
    await page.getByRole('button', { name: 'Video' }).click();
    // The first part is there.
    await page.getByRole('button', { name: /End the video \(/ }).waitFor();
    const video = await saved(page, () => page.getByRole('button', { name: 'End the video' }).click());
    expect(video.suggestedFilename()).toMatch(/^blue-rope\.(webm|mp4)$/);
    expect(readFileSync(await video.path()).length).toBeGreaterThan(2000);
    await visit.close();
  });

  it('gives the picture all the room there is', async () => {
    const visit = await play();
    const { page } = visit;
    const width = async (): Promise<number> => (await page.locator('.stage').boundingBox())!.width;
    const before = await width();
    await page.getByRole('button', { name: 'Hide panels' }).click();
    expect(await width()).toBeGreaterThan(before + 300);
    await page.getByText('Hands and pointers').waitFor({ state: 'hidden' });
    await page.getByRole('button', { name: 'Full screen' }).click();
    await page.getByRole('button', { name: 'Full screen', pressed: true }).waitFor();
    await visit.stop('play-full-screen');
    await page.getByRole('button', { name: 'Full screen' }).click();
    await page.getByRole('button', { name: 'Full screen', pressed: false }).waitFor();
    await page.getByRole('button', { name: 'Show panels' }).click();
    await page.getByText('Hands and pointers').waitFor();
    await visit.close();
  });

  it('fits a small screen', async () => {
    const options = { at: `/twins/${twin}/play`, viewport: { width: 360, height: 740 }, colorScheme: 'dark' } as const;
    const visit = await Visit.open(browser, server, options);
    await visit.page.getByText('frames/s simulated').waitFor();
    expect(await visit.page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(360);
    await visit.stop('small-dark-play');
    await visit.close();
  });

  it('shows the surface, springs and triplets of a twin at rest', async () => {
    const visit = await Visit.open(browser, server, { at: `/twins/${twin}/view` });
    const { page } = visit;
    const skin = page.getByRole('checkbox', { name: 'Skin' });
    const surface = await settled(page);
    await visit.stop('view-surface');
    await skin.uncheck();
    const pixels = changed(surface, await settled(page), 60);
    // A surface in the colours of the rope, of which parts are seen more than others, and no single colour.
    expect(pixels.length).toBeGreaterThan(3000);
    expect(distance(mean(surface, pixels), await coloursOf(twin))).toBeLessThan(90);
    await page.getByRole('checkbox', { name: 'Springs' }).check();
    await page.getByRole('checkbox', { name: 'Bending triplets' }).check();
    expect(new URLSearchParams(page.url().split('?')[1]).get('layers')).toBe('appearance,shadow,springs,triplets');
    await page.getByRole('combobox', { name: 'Colour by' }).selectOption('stiffness');
    await page.getByText('Stiffness of springs').waitFor();
    expect(page.url()).toContain('colour=stiffness');
    await visit.stop('view');
    await page.reload();
    expect(await page.getByRole('checkbox', { name: 'Bending triplets' }).isChecked()).toBe(true);
    await page.getByRole('link', { name: 'Play with it' }).click();
    await page.getByText('frames/s simulated').waitFor();
    await visit.close();
  });

  it('goes on from what was seen when the server is killed', async () => {
    const visit = await play();
    const { page } = visit;
    visit.allow(/WebSocket|ERR_CONNECTION_REFUSED|ERR_CONNECTION_RESET|ERR_EMPTY_RESPONSE|ERR_INCOMPLETE/);
    await lift(page);
    await server.kill();
    await page.getByText('The connection is lost').waitFor();
    await visit.stop('play-lost');
    await server.start();
    await page.getByText('The play continues from what you saw').waitFor({ timeout: 600_000 });
    await page.getByText('frames/s simulated').waitFor();
    // The pointer has taken hold again.
    await page.getByText('Pointer 1 holds').waitFor();
    await visit.stop('play-back');
    await visit.close();
  });
});

/** Mean colour of the vertices of a twin's surface. */
async function coloursOf(twin: string): Promise<Colour> {
  const api = { fetch: (path: string, init: RequestInit) => fetch(server.url + path, init) } as unknown as Api;
  const { tensors, read } = await openTwinFile(api, twin, new AbortController().signal);
  const colours = await read(...tensors.get('surface.color')!.data_offsets);
  const data = new Uint8ClampedArray((4 * colours.length) / 3).map((_, i) => (i % 4 === 3 ? 255 : colours[3 * (i >> 2) + (i % 4)]!));
  const pixels = Array.from({ length: data.length / 4 }, (_, i) => i);
  return mean({ width: pixels.length, height: 1, data }, pixels);
}

/** The link of the moment. */
async function link(page: Page): Promise<string> {
  await page.getByRole('button', { name: 'Copy link' }).click();
  return page.getByLabel('Link').inputValue();
}

async function saved(page: Page, act: () => Promise<void>): Promise<Download> {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return download;
}

/** The text of a file that a button saves. */
async function text(page: Page, button: string): Promise<string> {
  const download = await saved(page, () => page.getByRole('button', { name: button }).click());
  return readFileSync(await download.path(), 'utf8');
}
