/** A ChArUco board that lies on the table of a made recording, painted into its images. */

import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import type { CameraHead } from '../../src/playback/file/head';

/** The board as a person would describe it, sizes in metres; it lies around the origin, larger
 * than what hides it. */
export const BOARD = { columns: 10, rows: 8, square: 0.1, marker: 0.075, dictionary: 'DICT_4X4_50' } as const;
/** Codes of the first markers of the dictionary, row by row, the first module in the highest bit. */
const CODES = [
  0xb532, 0x0f9a, 0x332d, 0x9946, 0x549e, 0x79cd, 0x9e2e, 0xc4f2, 0xfeda, 0xcf56, 0xf991, 0x11a7, 0x0eb7, 0x2a0f,
  0x24b1, 0x263e, 0x4665, 0x6600, 0x6c5e, 0x76af, 0x868b, 0xb02b, 0xccd5, 0xdd82, 0xfe47, 0x9471, 0xace4, 0xa554,
  0x2123, 0x346f, 0x4415, 0x57b2, 0x9ecf, 0xf0cb, 0x08ae, 0x0929, 0x1875, 0x04ff, 0x0df6, 0x1c5a, 0x1718, 0x2a28,
  0x328c, 0x38b2, 0x24e8, 0x2eeb, 0x2d3f, 0x4b64, 0x502e, 0x5013,
];

/** Paints the board into all colour images of a case, where neither object nor hand hides it. */
export async function paintBoard(page: Page, folder: string, cameras: readonly Placed[]): Promise<void> {
  for (const [index, camera] of cameras.entries()) {
    const colour = join(folder, 'color', String(index));
    for (const name of readdirSync(colour)) {
      const masks = [0, 1].map((label) => base64(join(folder, 'mask', String(index), String(label), name)));
      const image = base64(join(colour, name));
      const painted = await page.evaluate(paint, { image, masks, camera, board: BOARD, codes: CODES });
      writeFileSync(join(colour, name), Buffer.from(painted, 'base64'));
    }
  }
}

/** A camera with its pose: camera to world, shape [3, 4]. */
export type Placed = CameraHead['intrinsics'] & { readonly pose: readonly number[] };

interface Job {
  readonly image: string;
  readonly masks: readonly string[];
  readonly camera: Placed;
  readonly board: typeof BOARD;
  readonly codes: readonly number[];
}

/** In the browser, which decodes and encodes images: the image with the board. */
async function paint({ image, masks, camera, board, codes }: Job): Promise<string> {
  const decode = async (text: string): Promise<[OffscreenCanvas, ImageData]> => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d')!;
    context.drawImage(bitmap, 0, 0);
    return [canvas, context.getImageData(0, 0, bitmap.width, bitmap.height)];
  };
  const [canvas, pixels] = await decode(image);
  const hidden = await Promise.all(masks.map(async (mask) => (await decode(mask))[1].data));
  const { columns, rows, square, marker } = board;
  /** Brightness of the board at a place on the table, or null beside its margin and some squares more. */
  const at = (x: number, y: number, more: number): number | null => {
    const [across, down] = [x / square + columns / 2, rows / 2 - y / square];
    const margin = 0.3 + more;
    if (across < -margin || down < -margin || across > columns + margin || down > rows + margin) return null;
    const [column, row] = [Math.floor(across), Math.floor(down)];
    if (column < 0 || row < 0 || column >= columns || row >= rows) return 225;
    if ((column + row) % 2 === 0) return 25;
    // Markers are numbered row by row; the white squares of a row are every second one.
    const above = Math.floor((row * columns) / 2);
    const code = codes[above + Math.floor(column / 2)]!;
    const inside = (part: number): number => Math.floor(((part - 0.5) * square) / marker * 6 + 3);
    const [u, v] = [inside(across - column), inside(down - row)];
    if (u < 0 || v < 0 || u > 5 || v > 5) return 225;
    if (u === 0 || v === 0 || u === 5 || v === 5) return 25;
    return (code >> (15 - (4 * (v - 1) + u - 1))) & 1 ? 225 : 25;
  };
  const { fx, fy, cx, cy, pose } = camera;
  const { width, height, data } = pixels;
  const PARTS = 3;
  /** Brightness of the board where a pixel sees it, or is that number of squares away. */
  const seen = (column: number, row: number, away: number): number | null => {
    const [dx, dy] = [(column - cx) / fx, (row - cy) / fy];
    const along = (k: number): number => pose[4 * k]! * dx + pose[4 * k + 1]! * dy + pose[4 * k + 2]!;
    const far = -pose[11]! / along(2);
    return far > 0 ? at(pose[3]! + far * along(0), pose[7]! + far * along(1), away) : null;
  };
  for (let row = 0; row < height; row += 1) {
    for (let column = 0; column < width; column += 1) {
      const i = 4 * (row * width + column);
      if (hidden.some((mask) => mask[i]! > 0) || seen(column, row, 1) === null) continue;
      let [sum, count] = [0, 0];
      for (let part = 0; part < PARTS * PARTS; part += 1) {
        const [right, down] = [((part % PARTS) + 0.5) / PARTS, (Math.floor(part / PARTS) + 0.5) / PARTS];
        const value = seen(column - 0.5 + right, row - 0.5 + down, 0);
        if (value === null) continue;
        sum += value;
        count += 1;
      }
      if (count === 0) continue;
      const share = count / (PARTS * PARTS);
      for (let k = 0; k < 3; k += 1) data[i + k] = (1 - share) * data[i + k]! + share * (sum / count);
    }
  }
  canvas.getContext('2d')!.putImageData(pixels, 0, 0);
  const bytes = new Uint8Array(await (await canvas.convertToBlob({ type: 'image/png' })).arrayBuffer());
  let text = '';
  for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
  return btoa(text);
}

function base64(path: string): string {
  return readFileSync(path).toString('base64');
}

/** The place deepest inside the part that a mask shows, as column and row. */
export async function middleOf(page: Page, mask: string): Promise<[number, number]> {
  return page.evaluate(async (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]));
    const { width, height } = bitmap;
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext('2d')!;
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    let left = Array.from({ length: width * height }, (_, i) => i).filter((i) => data[4 * i]! > 0);
    if (left.length === 0) throw new Error('the mask is empty');
    // Rim after rim is taken away; one of the last pixels is in the middle.
    for (;;) {
      const there = new Set(left);
      const inner = left.filter((i) => [i - 1, i + 1, i - width, i + width].every((n) => there.has(n)));
      if (inner.length === 0) break;
      left = inner;
    }
    const middle = left[Math.floor(left.length / 2)]!;
    return [middle % width, Math.floor(middle / width)] as [number, number];
  }, base64(mask));
}
