import type { Page } from 'playwright-core';
import { describe, expect, it } from 'vitest';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

/** Twins of the list, and those of one page. */
const ALL = 1000;
const PAGE = 100;
/** Most time of the page's thread until the first rows are drawn [ms]; other programs do not count. */
const MOST_MS = 1000;
/** Most time of the page's thread for a picture while the list is scrolled [ms], for 30 pictures a second. */
const MOST_PICTURE_MS = 33;

/** A picture of one grey pixel. */
const PIXEL = Buffer.from(
  'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==',
  'base64',
);

describe('the list of twins', () => {
  withServer(['--client-token', 'none', '--workers', '0']);

  it('has a thousand twins as quickly as a few', async () => {
    const visit = await Visit.open(browser, server, { at: '/upload' });
    const { page } = visit;
    const pictures = await withTwins(page);
    await visit.heading('Upload');
    const thread = await threadTime(page);
    const before = await thread();
    await visit.go('/twins');
    await page.getByRole('link', { name: 'twin 0', exact: true }).waitFor();
    const toRows = (await thread()) - before;
    await page.getByText('1,000 twins').waitFor();
    expect(await page.locator('tbody tr').count()).toBe(PAGE);
    await page.locator('.thumbnail img').first().waitFor();
    expect(pictures(), 'pictures that are far away wait').toBeLessThan(PAGE / 2);
    const frames = 60;
    const still = await thread();
    await page.evaluate(async (count) => {
      for (let frame = 0; frame < count; frame += 1) {
        scrollBy(0, 60);
        await new Promise(requestAnimationFrame);
      }
    }, frames);
    const eachFrame = ((await thread()) - still) / frames;
    console.log(`${Math.round(toRows)} ms to the first rows, ${eachFrame.toFixed(1)} ms for each picture`);
    expect(toRows).toBeLessThan(MOST_MS);
    expect(eachFrame).toBeLessThan(MOST_PICTURE_MS);
    const header = await page.getByRole('columnheader', { name: 'Verdict' }).boundingBox();
    expect(header?.y, 'the header stays below the bar').toBeCloseTo(48, -1);
    await visit.stop('twins-many');
    await page.getByRole('button', { name: 'Next' }).click();
    await page.getByRole('link', { name: 'twin 100', exact: true }).waitFor();
    await visit.close();
  });

  it('can be filtered by verdict, and several of it are compared, tagged and deleted', async () => {
    const visit = await Visit.open(browser, server, { at: '/twins' });
    const { page } = visit;
    await withTwins(page);
    await page.reload();
    await page.getByLabel('Verdict').selectOption('fair');
    await page.getByText('333 twins with verdict “\u2068fair\u2069”').waitFor();
    expect(new URL(page.url()).hash).toContain('level=fair');
    // The mark of the order moves no header.
    const sort = page.getByRole('button', { name: 'Name', exact: true });
    const header = page.getByRole('columnheader', { name: 'Error' });
    const places = () => Promise.all([sort.boundingBox(), header.boundingBox()]);
    const before = await places();
    await sort.click();
    await page.locator('th[aria-sort=ascending]').waitFor();
    expect(await places()).toEqual(before);
    const bar = page.getByRole('region', { name: 'Selection' });
    for (const name of ['twin 1', 'twin 4']) await page.getByRole('checkbox', { name: `Select ${name}`, exact: true }).check();
    await bar.getByText('2 twins selected').waitFor();
    const compare = bar.getByRole('link', { name: 'Compare' });
    expect((await compare.getAttribute('href'))?.split(',').length).toBe(2);
    for (const name of ['Add tags', 'Delete']) await bar.getByRole('button', { name }).waitFor();
    await visit.stop('twins-selected');
    await bar.getByRole('button', { name: 'Delete' }).click();
    await page.getByRole('dialog').getByText('Delete 2 twins?').waitFor();
    await page.keyboard.press('Escape');
    await visit.close();
  });

  it('says what twins are while there are none', async () => {
    const visit = await Visit.open(browser, server, { at: '/twins' });
    await visit.page.getByRole('heading', { name: 'No twins yet' }).waitFor();
    await visit.page.getByRole('link', { name: 'Start a fit' }).waitFor();
    await visit.stop('twins-empty');
    await visit.close();
  });
});

/** Answers for the server with a thousand twins and their pictures; gives the number of pictures asked for. */
async function withTwins(page: Page): Promise<() => number> {
  let pictures = 0;
  const levels = ['good', 'fair', 'poor'];
  const errors = (track_m: number) => ({ track_m, chamfer_l1_m: null, chamfer_l2_m: null, coordinate_m: null });
  const all = Array.from({ length: ALL }, (_, index) => ({
    name: `twins/01999999-9999-7999-8999-${String(index).padStart(12, '0')}`,
    display_name: `twin ${index}`,
    create_time: '2026-01-01T00:00:00Z',
    node_count: 100,
    tags: [],
    quality: {
      assessment: { level: levels[index % 3], why: '', next: '' },
      scores: [{ predictor: 'bending', train: errors(0.001), future: errors(0.002) }],
    },
  }));
  await page.route(/\/v1\/twins\?/, (route) => {
    const query = new URL(route.request().url()).searchParams;
    const found = all.filter(({ quality }) => [quality.assessment.level, null].includes(query.get('level')));
    const start = Number(query.get('page_token') ?? 0);
    const end = start + Number(query.get('page_size'));
    const next_page_token = end < found.length ? String(end) : '';
    return route.fulfill({ json: { twins: found.slice(start, end), next_page_token, total_size: found.length } });
  });
  await page.route(/\/thumbnail/, (route) => {
    pictures += 1;
    return route.fulfill({ body: PIXEL, contentType: 'image/png' });
  });
  return () => pictures;
}

/** A clock of the processor time that the page's thread has taken [ms]. */
async function threadTime(page: Page): Promise<() => Promise<number>> {
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  return async () => {
    const { metrics } = await session.send('Performance.getMetrics');
    return 1000 * (metrics.find(({ name }) => name === 'TaskDuration')?.value ?? NaN);
  };
}
