import type { Page } from 'playwright-core';

/** A picture of a part of the page: columns, rows, and red, green, blue, opacity of each pixel. */
export interface Picture {
  readonly width: number;
  readonly height: number;
  readonly data: Uint8ClampedArray;
}

/** A rectangle of the page [pixels]. */
export type Area = { readonly x: number; readonly y: number; readonly width: number; readonly height: number };

export type Colour = readonly [number, number, number];

/** What a person sees of the 3D view once it does not change any more. */
export async function settled(page: Page): Promise<Picture> {
  let last = await pictureOf(page);
  for (let tries = 0; tries < 40; tries += 1) {
    // Longer than a picture takes that is drawn without a GPU beside other work.
    await page.waitForTimeout(250);
    const next = await pictureOf(page);
    if (changed(last, next, 8).length === 0) return next;
    last = next;
  }
  throw new Error('the picture keeps changing');
}

/** What a person sees of an area of the page, by default of the 3D view. */
export async function pictureOf(page: Page, area?: Area): Promise<Picture> {
  const clip = area ?? (await page.locator('.stage canvas').boundingBox());
  if (clip === null) throw new Error('there is no picture');
  const png = (await page.screenshot({ clip })).toString('base64');
  const decoded = await page.evaluate(async (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes]));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d')!;
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let binary = '';
    for (let i = 0; i < data.length; i += 8192) binary += String.fromCharCode(...data.subarray(i, i + 8192));
    return { width: image.width, height: image.height, text: btoa(binary) };
  }, png);
  const data = new Uint8ClampedArray(Buffer.from(decoded.text, 'base64'));
  return { width: decoded.width, height: decoded.height, data };
}

/** Indices of pixels whose colours in two pictures are further apart than this. */
export function changed(a: Picture, b: Picture, least: number): number[] {
  const pixels = Array.from({ length: a.width * a.height }, (_, i) => i);
  return pixels.filter((i) => distance(colourAt(a, i), colourAt(b, i)) > least);
}

/** Mean colour of some pixels. */
export function mean(picture: Picture, pixels: readonly number[]): Colour {
  const sum = [0, 0, 0];
  for (const pixel of pixels) colourAt(picture, pixel).forEach((value, k) => (sum[k]! += value));
  return sum.map((value) => value / Math.max(pixels.length, 1)) as unknown as Colour;
}

/** Mean row of some pixels. */
export function meanRow(picture: Picture, pixels: readonly number[]): number {
  return pixels.reduce((sum, pixel) => sum + Math.floor(pixel / picture.width), 0) / Math.max(pixels.length, 1);
}

/** Euclidean distance of two colours. */
export function distance(a: Colour, b: Colour): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

export function colourAt({ data }: Picture, pixel: number): Colour {
  return [data[4 * pixel]!, data[4 * pixel + 1]!, data[4 * pixel + 2]!];
}
