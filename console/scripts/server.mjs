// A server of its own: the binary of the repository in an empty folder, on a free port.

import { execFile, spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { isAbsolute, join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const ROOT = fileURLToPath(new URL('../../', import.meta.url));
const START_MS = 60_000;

/** The command `bendtwin`: BENDTWIN_BIN, as of tests/run, or what `cargo build` makes. */
export function binary() {
  const given = process.env['BENDTWIN_BIN'] ?? join(process.env['CARGO_TARGET_DIR'] ?? 'target', 'debug/bendtwin');
  return isAbsolute(given) ? given : join(ROOT, given);
}

/** A server that can be killed and started again in the same folder and at the same port. */
export class Server {
  /** @type {import('node:child_process').ChildProcess | null} */
  #process = null;
  #log = '';
  #port;
  #home = mkdtempSync(join(tmpdir(), 'bendtwin-console-'));

  /**
   * @param {string[]} options Options of `bendtwin server`.
   * @param {number} port 0 takes a free one.
   */
  constructor(options = [], port = 0) {
    this.options = options;
    this.#port = port;
  }

  /**
   * @param {string[]} options
   * @param {number} port
   */
  static async start(options = [], port = 0) {
    const server = new Server(options, port);
    await server.start();
    return server;
  }

  get url() {
    return `http://127.0.0.1:${this.#port}`;
  }

  /** The token, once a server that wants one has run. */
  get token() {
    return readFileSync(join(this.#home, 'data/client-token'), 'utf8').trim();
  }

  /** What the server has printed. */
  get log() {
    return this.#log;
  }

  /** Environment in which commands find this server, and no other that runs on the machine. */
  get environment() {
    return { ...process.env, HOME: this.#home, XDG_STATE_HOME: this.#home, BENDTWIN_SERVER: this.url };
  }

  /**
   * Runs `bendtwin` against this server, in the server's folder; gives what it prints.
   * @param {string[]} args
   * @returns {Promise<string>}
   */
  async run(...args) {
    const { stdout } = await promisify(execFile)(binary(), args, { env: this.environment, cwd: this.#home });
    return stdout;
  }

  /** Starts the process and waits until it answers. */
  async start() {
    const portFile = join(this.#home, 'port');
    rmSync(portFile, { force: true });
    const listen = ['--listen', `127.0.0.1:${this.#port}`, '--port-file', portFile];
    const args = ['server', '--data-dir', join(this.#home, 'data'), '--exit-with-parent', ...listen, ...this.options];
    const child = spawn(binary(), args, { env: this.environment, stdio: ['pipe', 'pipe', 'pipe'] });
    this.#process = child;
    const note = (/** @type {Buffer} */ piece) => (this.#log += piece.toString());
    child.stdout.on('data', note);
    child.stderr.on('data', note);
    let fault = '';
    child.on('error', (error) => (fault = error.message));
    child.on('exit', (code) => (fault ||= `it ended with ${code}`));
    const until = Date.now() + START_MS;
    while (fault === '' && Date.now() < until) {
      const port = await portOf(portFile);
      if (port !== null) {
        this.#port = port;
        return;
      }
      await sleep(20);
    }
    throw new Error(`${binary()} did not start: ${fault || 'no port in time'}\n${this.#log}`);
  }

  /** Ends the process as a power cut would. */
  async kill() {
    const child = this.#process;
    if (child === null) return;
    this.#process = null;
    const ended = new Promise((resolve) => child.once('exit', resolve));
    if (child.exitCode === null && child.signalCode === null) {
      child.kill('SIGKILL');
      await ended;
    }
  }

  /** Ends the process and removes its folder. */
  async remove() {
    await this.kill();
    rmSync(this.#home, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
  }
}

/**
 * The port that a server has written, or null.
 * @param {string} file
 */
async function portOf(file) {
  try {
    return Number(readFileSync(file, 'utf8'));
  } catch {
    return null;
  }
}
