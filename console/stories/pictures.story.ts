import { writeFileSync } from 'node:fs';
import type { Page } from 'playwright-core';
import { describe, expect, it } from 'vitest';
import { animation } from './kit/animation';
import { colourAt, distance, pictureOf, type Picture } from './kit/pixels';
import { fitted } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { SCREENSHOTS, Visit } from './kit/visit';

type Place = readonly [x: number, y: number];

/** Frames of the simulation from one picture to the next; a second has 30. */
const EVERY = 2;
/** Time of a picture, a little longer than its frames take, and of the last one [ms]. */
const PICTURE_MS = 75;
const LAST_MS = 1000;
/** The frame of a playback, which the twin was not fitted to. */
const FRAME = 60;
/** Places of the pointer from where it grasps [pixels], one for each picture; null once it has let go. */
const STEPS: readonly (Place | null)[] = [
  ...path([0, 0], [-15, -60], 8),
  ...path([-15, -60], [-120, -190], 16),
  ...path([-120, -190], [-20, -140], 12),
  ...Array.from({ length: 20 }, () => null),
];

/** `docs/pictures/console-*.png`: copies of the screenshots of these names. */
describe('pictures of the documents', () => {
  withServer();

  it('show a rope that is lifted, bent and dropped', async () => {
    const { twin } = await fitted(server, 'blue rope', ['rope'], { search: { generations: 1 }, refine: { passes: 1 } });
    const visit = await Visit.open(browser, server, { viewport: { width: 1040, height: 640 } });
    const { page } = visit;
    const seen = seenStates(page);
    await visit.go(`/twins/${twin}/play`);
    await page.getByText('frames/s simulated').waitFor();
    const [x, y] = await endOfRope(page);
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.getByText('Pointer 1 holds').waitFor();
    // The simulation waits for each picture. The mouse is busy.
    const press = (name: string): Promise<void> => page.getByRole('button', { name }).dispatchEvent('click');
    await press('Pause');
    const pictures: Picture[] = [];
    for (const step of STEPS) {
      if (step === null) await page.mouse.up();
      else await page.mouse.move(x + step[0], y + step[1]);
      const before = seen();
      for (let frame = 0; frame < EVERY; frame += 1) await press('Step');
      await expect.poll(seen, { interval: 10 }).toBeGreaterThanOrEqual(before + EVERY);
      // Without the bar of the page above and the line of times below.
      pictures.push(await pictureOf(page, { x: 0, y: 60, width: 1040, height: 545 }));
    }
    await visit.stop('console-play');
    const file = animation(pictures, PICTURE_MS, LAST_MS);
    writeFileSync(`${SCREENSHOTS}console-play.png`, file);
    expect(file.length).toBeLessThan(2e6);
    const shown = await decoded(page, file);
    expect(shown.length).toBe(pictures.length);
    for (const [index, picture] of pictures.entries()) expect(apart(shown[index]!, picture)).toBeLessThan(4);
    await visit.close();
  });

  it('show a foam bar with its prediction, and the error of every frame', async () => {
    const { capture, twin } = await fitted(server, 'foam bar', ['bar', '--raw'], { effort: 'draft', seed: 1 });
    const at = `/captures/${capture}/playback?twin=${twin}&frame=${FRAME}`;
    const visit = await Visit.open(browser, server, { at, viewport: { width: 1200, height: 700 } });
    const { page } = visit;
    await page.getByText('Error (not fitted to this frame):').waitFor();
    await visit.stop('console-playback');
    // The page from its heading to the errors, which is higher than the window.
    const { y, height } = (await page.locator('.axis-legend').boundingBox())!;
    const clip = { x: 0, y: 60, width: 1200, height: y + height - 54 };
    await page.screenshot({ path: `${SCREENSHOTS}console-playback.png`, fullPage: true, clip });
    await visit.close();
  });
});

/** Places from one to another, without the first, slow at both ends. */
function path(from: Place, to: Place, count: number): Place[] {
  return Array.from({ length: count }, (_, i) => {
    const share = (1 - Math.cos((Math.PI * (i + 1)) / count)) / 2;
    return [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
  });
}

/** Number of the last state that the page has drawn. */
function seenStates(page: Page): () => number {
  let last = -1;
  page.on('websocket', (socket) =>
    socket.on('framesent', ({ payload }) => {
      const message = JSON.parse(String(payload)) as { type: string; frame?: number };
      if (message.type === 'seen') last = message.frame ?? last;
    }));
  return () => last;
}

/** The right end of the rope, which is red and yellow, in pixels of the page. */
async function endOfRope(page: Page): Promise<Place> {
  const picture = await pictureOf(page);
  const { x, y } = (await page.locator('.stage canvas').boundingBox())!;
  const isRope = Array.from({ length: picture.width * picture.height }, (_, i) => i).filter((i) => {
    const [red, green, blue] = colourAt(picture, i);
    return red - blue > 50 && green - blue > 20;
  });
  const end = isRope.reduce((best, i) => (i % picture.width > best % picture.width ? i : best));
  // A little inside of it.
  return [x + (end % picture.width) - 6, y + Math.floor(end / picture.width)];
}

/** The pictures of an animation as the browser shows them. */
async function decoded(page: Page, file: Buffer): Promise<Picture[]> {
  const frames = await page.evaluate(async (text) => {
    const data = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const decoder = new ImageDecoder({ data, type: 'image/png' });
    await decoder.tracks.ready;
    const all: { width: number; height: number; text: string }[] = [];
    for (let frameIndex = 0; frameIndex < decoder.tracks.selectedTrack!.frameCount; frameIndex += 1) {
      const { image } = await decoder.decode({ frameIndex });
      const { displayWidth: width, displayHeight: height } = image;
      const context = new OffscreenCanvas(width, height).getContext('2d')!;
      context.drawImage(image, 0, 0);
      image.close();
      let binary = '';
      const pixels = context.getImageData(0, 0, width, height).data;
      for (let i = 0; i < pixels.length; i += 8192) binary += String.fromCharCode(...pixels.subarray(i, i + 8192));
      all.push({ width, height, text: btoa(binary) });
    }
    return all;
  }, file.toString('base64'));
  return frames.map(({ width, height, text }) => {
    return { width, height, data: new Uint8ClampedArray(Buffer.from(text, 'base64')) };
  });
}

/** Mean distance of the colours of two pictures, from 0 to 255 a channel. */
function apart(a: Picture, b: Picture): number {
  let sum = 0;
  for (let i = 0; i < a.width * a.height; i += 1) sum += distance(colourAt(a, i), colourAt(b, i));
  return sum / (a.width * a.height);
}
