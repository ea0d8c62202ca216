/** Gestures with the mouse on the picture of a twin. */

import type { Page } from 'playwright-core';

/** The middle of the picture, where the camera looks at the object, in pixels of the page. */
export async function middle(page: Page): Promise<[number, number]> {
  const box = await page.locator('canvas').boundingBox();
  if (box === null) throw new Error('there is no picture');
  return [box.x + box.width / 2, box.y + box.height / 2];
}

/** Lifts the middle of the object with a pointer, which keeps hold of it. */
export async function lift(page: Page): Promise<void> {
  const [x, y] = await middle(page);
  await page.keyboard.down('Shift');
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x, y - 150, { steps: 15 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  await page.getByText('Pointer 1 holds').waitFor();
}
