import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser } from 'playwright-core';
import { afterAll, beforeAll, describe, it } from 'vitest';
import { Server } from '../scripts/server.mjs';
import { fittedRope } from './kit/rope';
import { Visit, launch } from './kit/visit';

describe('a play that nobody touches', () => {
  const folder = mkdtempSync(join(tmpdir(), 'bendtwin-config-'));
  const config = join(folder, 'config.toml');
  let server: Server;
  let browser: Browser;
  beforeAll(async () => {
    writeFileSync(config, '[limits]\nplay_idle_s = 4.0\n');
    [server, browser] = await Promise.all([Server.start(['--client-token', 'none', '--config', config]), launch()]);
  });
  afterAll(async () => {
    await browser.close();
    await server.remove();
    rmSync(folder, { recursive: true });
  });

  it('ends, and goes on from there when one wants to', async () => {
    const twin = await fittedRope(server);
    const visit = await Visit.open(browser, server, { at: `/twins/${twin}/play` });
    const { page } = visit;
    await page.getByText('The play has ended.').waitFor();
    await visit.stop('play-idle');
    await page.getByRole('button', { name: 'Play on' }).click();
    await page.getByText('The play continues from what you saw').waitFor();
    await page.getByText('The play has ended.').waitFor({ state: 'hidden' });
    await visit.close();
  });
});
