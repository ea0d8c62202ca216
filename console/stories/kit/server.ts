import type { Browser } from 'playwright-core';
import { afterAll, afterEach, beforeAll } from 'vitest';
import { Server } from '../../scripts/server.mjs';
import { launch } from './visit';

/** The server of a file's stories, once `withServer` has started it. */
export let server: Server;
/** Chromium beside it. */
export let browser: Browser;

/** Starts a server, by default one without a token, and Chromium for the stories of a file; both end after them. */
export function withServer(options = ['--client-token', 'none']): void {
  beforeAll(async () => {
    [server, browser] = await Promise.all([Server.start(options), launch()]);
  });
  // What a story that failed has left open would be played on.
  afterEach(async () => {
    await Promise.all(browser.contexts().map((context) => context.close()));
  });
  afterAll(async () => {
    await browser.close();
    await server.remove();
  });
}
