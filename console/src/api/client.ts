import { Client } from '@bendtwin/client';
import { token } from './token';

/** Requests to the server that the page came from, with the token of the tab. */
export class Api extends Client {
  constructor() {
    super({ token });
    // A page has something to show as soon as the server is back, whether or not a request waits for it.
    this.connection.addEventListener('lost', () => void this.connection.back());
  }

  /** Sends a body as JSON. */
  send<T>(method: string, path: string, body: unknown, signal: AbortSignal): Promise<T> {
    const headers = { 'content-type': 'application/json' };
    return this.json<T>(path, { method, headers, signal, body: JSON.stringify(body) });
  }
}
