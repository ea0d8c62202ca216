import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { afterAll, describe, it } from 'vitest';
import { fittedRope } from './kit/rope';
import { browser, server, withServer } from './kit/server';
import { Visit } from './kit/visit';

describe('a play that nobody touches', () => {
  const folder = mkdtempSync(join(tmpdir(), 'bendtwin-config-'));
  const config = join(folder, 'config.toml');
  writeFileSync(config, '[limits]\nplay_idle_s = 4.0\n');
  withServer(['--client-token', 'none', '--config', config]);
  afterAll(() => rmSync(folder, { recursive: true }));

  it('ends, and resumes when one wants to', async () => {
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
