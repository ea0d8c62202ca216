import { mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import type { Browser, BrowserContextOptions, Page } from 'playwright-core';
import { expect } from 'vitest';
import type { Server } from '../../scripts/server.mjs';
import { barriers } from './barriers';
import { serveDist } from './dist';

export const SCREENSHOTS = fileURLToPath(new URL('../../screenshots/', import.meta.url));
/** No network but the machine's own, and WebGL in software. */
const ARGUMENTS = [
  '--no-sandbox',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--ignore-gpu-blocklist',
  '--disable-background-networking',
];

/** Chromium as stories use it. */
export function launch(): Promise<Browser> {
  const executablePath = process.env['BENDTWIN_CHROMIUM'] ?? '/usr/bin/chromium';
  return chromium.launch({ executablePath, args: ARGUMENTS });
}

/** Longest wait for something on a page: a bound, not an expectation, for machines that are busy otherwise [ms]. */
const DEADLINE_MS = 120_000;

export interface VisitOptions extends BrowserContextOptions {
  /** Address behind the `#`, as `/captures`. */
  readonly at?: string;
}

/** A person's visit to the console of a server: a page, and what went wrong in it. */
export class Visit {
  readonly faults: string[] = [];
  private readonly allowed: RegExp[] = [];

  private constructor(
    readonly page: Page,
    private readonly server: Server,
  ) {}

  /** Opens the console in a fresh profile. */
  static async open(browser: Browser, server: Server, { at = '/', ...options }: VisitOptions = {}): Promise<Visit> {
    const context = await browser.newContext({ viewport: { width: 1200, height: 800 }, ...options });
    if (process.env['BENDTWIN_CONSOLE'] === 'dist') await serveDist(context, server.url);
    const page = await context.newPage();
    page.setDefaultTimeout(DEADLINE_MS);
    const visit = new Visit(page, server);
    page.on('pageerror', (error) => visit.note(`error: ${error.message}`));
    page.on('console', (message) => {
      if (message.type() === 'error') visit.note(`console: ${message.text()} (${message.location().url})`);
    });
    page.on('request', (request) => {
      const { protocol, origin } = new URL(request.url());
      if (protocol.startsWith('http') && origin !== server.url) visit.note(`another host: ${request.url()}`);
    });
    await page.addInitScript(() => {
      addEventListener('securitypolicyviolation', (event) => {
        console.error(`policy: ${event.violatedDirective} ${event.blockedURI} ${event.sample}`);
      });
    });
    await page.goto(`${server.url}/#${at}`);
    return visit;
  }

  /** Goes to another address of the console, as a link would. */
  async go(at: string): Promise<void> {
    await this.page.evaluate((hash) => (location.hash = hash), at);
  }

  /** Errors that belong to the story, such as a request to a server that was killed. */
  allow(...patterns: RegExp[]): void {
    this.allowed.push(...patterns);
    // The page may have been quicker than the story.
    const others = this.faults.filter((fault) => !patterns.some((pattern) => pattern.test(fault)));
    this.faults.splice(0, this.faults.length, ...others);
  }

  /** Waits until the heading says this. */
  async heading(text: string): Promise<void> {
    await this.page.getByRole('heading', { level: 1, name: text, exact: true }).waitFor();
  }

  /** Takes a picture and looks for what keeps people out; either kind of fault fails the story. */
  async stop(name: string): Promise<void> {
    mkdirSync(SCREENSHOTS, { recursive: true });
    await this.page.screenshot({ path: `${SCREENSHOTS}${name}.png` });
    expect(await barriers(this.page), `accessibility of ${name}`).toEqual([]);
    expect(this.faults, `errors of the page up to ${name}`).toEqual([]);
  }

  /** Ends the visit; errors that no stop has seen fail the story. */
  async close(): Promise<void> {
    await this.page.context().close();
    expect(this.faults, `errors of the page; the server's log:\n${this.server.log.slice(-2000)}`).toEqual([]);
  }

  private note(fault: string): void {
    if (!this.allowed.some((pattern) => pattern.test(fault))) this.faults.push(fault);
  }
}
