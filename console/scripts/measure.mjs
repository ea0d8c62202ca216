// Measures the console in Chromium, which draws in software:
//
//   node scripts/measure.mjs picture [NODES POINTS]         time of a picture of so many moving nodes and skin points
//   node scripts/measure.mjs surface [TRIANGLES NODES]      the same of a surface
//   node scripts/measure.mjs splats [N NODES]               the same of splats, which get fewer where pictures are slow
//   node scripts/measure.mjs playback URL CAPTURE           time of a picture of a playback, with the best twin
//   node scripts/measure.mjs object URL TWIN                time until the page of a twin shows the object, from an empty cache
//   node scripts/measure.mjs play URL TWIN [SECONDS]        time from an input to the picture that has it, and memory
//
// The server of `play`, `playback` and `object` is one that runs, for example `bendtwin server --client-token none`; for one with a
// token BENDTWIN_TOKEN has it.

import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { createServer } from 'vite';

const ROOT = fileURLToPath(new URL('..', import.meta.url));
const ARGUMENTS = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'];
/** Inputs a second, as a mouse has them. */
const INPUTS = 60;

const [what, ...rest] = process.argv.slice(2);
const executablePath = process.env['BENDTWIN_CHROMIUM'] ?? '/usr/bin/chromium';
const browser = await chromium.launch({ executablePath, args: [...ARGUMENTS, '--js-flags=--expose-gc'] });
try {
  if (what === 'picture') await picture(Number(rest[0] ?? 10_000), Number(rest[1] ?? 5_000));
  else if (what === 'surface') await picture(Number(rest[1] ?? 1_000), 0, { triangles: Number(rest[0] ?? 8_000) });
  else if (what === 'splats') await picture(Number(rest[1] ?? 1_000), 0, { splats: Number(rest[0] ?? 20_000) });
  else if (what === 'playback' && rest[0] !== undefined && rest[1] !== undefined) await playback(rest[0], rest[1]);
  else if (what === 'object' && rest[0] !== undefined && rest[1] !== undefined) await object(rest[0], rest[1]);
  else if (what === 'play' && rest[0] !== undefined && rest[1] !== undefined) {
    await play(rest[0], rest[1], Number(rest[2] ?? 20));
  } else throw new Error('say `picture`, `surface`, `splats`, `playback URL CAPTURE`, `object URL TWIN` or `play URL TWIN`');
} finally {
  await browser.close();
}

/**
 * @param {number} nodes
 * @param {number} points
 * @param {{ splats?: number, triangles?: number }} others
 */
async function picture(nodes, points, { splats = 0, triangles = 0 } = {}) {
  const server = await createServer({ root: ROOT, logLevel: 'error', server: { port: 0, host: '127.0.0.1' } });
  await server.listen();
  const address = server.resolvedUrls?.local[0];
  const page = await browser.newPage({ viewport: { width: 1200, height: 800 } });
  const before = await work();
  await page.goto(`${address}bench/index.html?nodes=${nodes}&points=${points}&splats=${splats}&triangles=${triangles}`);
  const text = await page.locator('pre').textContent({ timeout: 120_000 });
  const after = await work();
  const { cpu, apart, drawn } = JSON.parse(text ?? '');
  const subject = splats > 0 ? `${splats} splats, at the end ${drawn}`
    : triangles > 0 ? `a surface of ${triangles} triangles` : `${points} points of skin`;
  console.log(`${nodes} nodes, ${subject}, ${cpu.length} pictures`);
  console.log(`JavaScript per picture: ${quantiles(cpu)}`);
  console.log(`between pictures: ${quantiles(apart)}, ${(1000 / mean(apart)).toFixed(1)} a second`);
  const each = [...after].map(([type, s]) => `${type} ${((1000 * (s - (before.get(type) ?? 0))) / cpu.length).toFixed(1)} ms`);
  console.log(`time of processors per picture, with the start of the page: ${each.join(', ')}`);
  await server.close();
}

/**
 * @param {string} url
 * @param {string} capture
 */
async function playback(url, capture) {
  process.env['BENDTWIN_SERVER'] = url;
  const server = await createServer({ root: ROOT, logLevel: 'error', server: { port: 0, host: '127.0.0.1' } });
  await server.listen();
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  const token = process.env['BENDTWIN_TOKEN'];
  const query = token === undefined ? '' : `?token=${token}`;
  await page.goto(`${server.resolvedUrls?.local[0]}#/${capture}/playback${query}`);
  await page.getByText('Error (fitted to this frame):').waitFor({ timeout: 120_000 });
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  const script = async () => {
    const { metrics } = await session.send('Performance.getMetrics');
    return metrics.find(({ name }) => name === 'ScriptDuration')?.value ?? NaN;
  };
  const [began, before] = [await script(), await work()];
  // Step by step, so that no frame is left out on a machine that is too slow to play.
  const apart = await page.evaluate(async () => {
    const button = /** @type {HTMLButtonElement} */ (document.querySelector('[aria-label="Next frame"]'));
    const slider = /** @type {HTMLInputElement} */ (document.querySelector('.axis-strip input'));
    const times = [performance.now()];
    while (slider.value !== slider.max) {
      button.click();
      times.push(await new Promise(requestAnimationFrame));
    }
    return times.slice(1).map((now, i) => now - (times[i] ?? now));
  });
  const [ended, after] = [await script(), await work()];
  console.log(`${apart.length} pictures, JavaScript per picture: ${((1000 * (ended - began)) / apart.length).toFixed(1)} ms of the processor`);
  console.log(`between pictures: ${quantiles(apart)}, ${(1000 / mean(apart)).toFixed(1)} a second`);
  const each = [...after].map(([type, s]) => `${type} ${((1000 * (s - (before.get(type) ?? 0))) / apart.length).toFixed(1)} ms`);
  console.log(`time of processors per picture: ${each.join(', ')}`);
  await server.close();
}

/** Time of processors that Chromium's processes have taken, by their type [s]. */
async function work() {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  await session.detach();
  const sums = new Map();
  for (const { type, cpuTime } of processInfo) sums.set(type, (sums.get(type) ?? 0) + cpuTime);
  return sums;
}

/**
 * Opens the page of a twin several times, each in a browser context that knows nothing of it yet.
 * @param {string} url
 * @param {string} twin
 */
async function object(url, twin) {
  const times = [];
  for (let visit = 0; visit < 5; visit += 1) {
    const context = await browser.newContext({ viewport: { width: 1200, height: 800 } });
    const page = await context.newPage();
    await page.addInitScript(() => {
      new MutationObserver((_, observer) => {
        if (document.querySelector('.stage canvas') === null) return;
        observer.disconnect();
        // The first of them draws, and the second begins once that has been shown.
        requestAnimationFrame(() => requestAnimationFrame((now) => Object.assign(window, { shown: now })));
      }).observe(document, { childList: true, subtree: true });
    });
    await page.goto(addressOf(url, twin, ''));
    const shown = await page.waitForFunction(() => /** @type {any} */ (window).shown);
    times.push(/** @type {number} */ (await shown.jsonValue()));
    await context.close();
  }
  console.log(`from the request of the page to the turning object: ${quantiles(times)}`);
}

/**
 * Address of a page of a twin, with the token if the server wants one.
 * @param {string} url
 * @param {string} twin
 * @param {string} page
 */
function addressOf(url, twin, page) {
  const token = process.env['BENDTWIN_TOKEN'];
  const query = token === undefined ? '' : `?token=${token}`;
  return `${url}/#/${twin.startsWith('twins/') ? twin : `twins/${twin}`}${page}${query}`;
}

/**
 * @param {string} url
 * @param {string} twin
 * @param {number} seconds
 */
async function play(url, twin, seconds) {
  const page = await browser.newPage({ viewport: { width: 1200, height: 800 } });
  await page.goto(addressOf(url, twin, '/play'));
  await page.getByText('frames/s simulated').waitFor();
  const box = await page.locator('canvas').boundingBox();
  if (box === null) throw new Error('there is no picture');
  await page.evaluate(() => {
    const found = /** @type {{ times: number[], drawn: number }} */ ({ times: [], drawn: 0 });
    Object.assign(window, { found });
    const canvas = document.querySelector('canvas');
    canvas?.addEventListener('bendtwin-acted', (event) => found.times.push(/** @type {CustomEvent} */ (event).detail));
  });
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const until = Date.now() + 1000 * seconds;
  const heaps = [await heap(page)];
  for (let input = 0; Date.now() < until; input += 1) {
    const begun = Date.now();
    await page.mouse.move(x + 60 * Math.sin(input / 20), y - 60 - 50 * Math.cos(input / 20));
    if (input % (20 * INPUTS) === 20 * INPUTS - 1) heaps.push(await heap(page));
    const pause = 1000 / INPUTS - (Date.now() - begun);
    if (pause > 0) await page.waitForTimeout(pause);
  }
  heaps.push(await heap(page));
  const times = await page.evaluate(() => /** @type {any} */ (window).found.times);
  console.log(`input to the first picture with it, ${times.length} inputs: ${quantiles(times)}`);
  console.log(await page.locator('.play-facts').innerText());
  console.log(`memory of the page [MB]: ${heaps.map((bytes) => (bytes / 1e6).toFixed(1)).join(', ')}`);
  await page.mouse.up();
}

/**
 * JavaScript's memory after a collection [bytes].
 * @param {import('playwright-core').Page} page
 */
async function heap(page) {
  const session = await page.context().newCDPSession(page);
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  await session.detach();
  return usedSize;
}

/** @param {number[]} values */
function quantiles(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (/** @type {number} */ share) => (sorted[Math.floor(share * (sorted.length - 1))] ?? NaN).toFixed(1);
  return `p50 ${at(0.5)} ms, p95 ${at(0.95)} ms, worst ${at(1)} ms`;
}

/** @param {number[]} values */
function mean(values) {
  return values.reduce((sum, value) => sum + value, 0) / Math.max(values.length, 1);
}
