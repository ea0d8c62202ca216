import { Connection, ServerLost } from './connection';
import { Problem, problemOf } from './problem';
import type { Path, Query, Reply } from './routes';
import { addressOf } from './routes';
import { token } from './token';

export { Problem };

/** Statuses with which a proxy says that there is no server behind it. */
const NO_SERVER = [502, 504];

/** Requests to the server that the page came from. Paths begin at `/v1`. */
export class Api {
  readonly connection = new Connection(async () => {
    try {
      return !NO_SERVER.includes((await fetch('/healthz', { cache: 'no-store' })).status);
    } catch {
      return false;
    }
  });

  /** Called when an answer asks for a token, or for another one. */
  onUnauthenticated: (problem: Problem) => void = () => undefined;

  /** The answer of a route to GET, with the types of the server's description. */
  get<P extends Path>(route: P, options: { id?: string; query?: Query<P>; signal: AbortSignal }): Promise<Reply<P>> {
    return this.json(addressOf(route, options.id, options.query), { signal: options.signal });
  }

  /** Answers with JSON, or throws a `Problem`, or `ServerLost`. */
  async json<T>(path: string, options: RequestInit = {}): Promise<T> {
    const answer = await this.fetch(path, options);
    return this.answered(answer.json() as Promise<T>, options.signal);
  }

  /** Sends a body as JSON. */
  send<T>(method: string, path: string, body: unknown, signal: AbortSignal): Promise<T> {
    const headers = { 'content-type': 'application/json' };
    return this.json<T>(path, { method, headers, signal, body: JSON.stringify(body) });
  }

  /** The answer itself, for streams and bytes; throws a `Problem` if it refuses, and `ServerLost`. */
  async fetch(path: string, options: RequestInit = {}): Promise<Response> {
    const headers = new Headers(options.headers);
    const shown = token();
    if (shown !== null) headers.set('authorization', `Bearer ${shown}`);
    // Without the browser's credentials there is no password prompt at a 401.
    const request = fetch(path, { ...options, headers, credentials: 'omit' });
    const answer = await this.answered(request, options.signal);
    if (answer.ok) return answer;
    const problem = await problemOf(answer);
    if (problem.status === 401) this.onUnauthenticated(problem);
    if (NO_SERVER.includes(problem.status) && problem.reason === '') {
      this.connection.lost();
      throw new ServerLost();
    }
    throw problem;
  }

  /** Result of a request or a body, with the one error that browsers have for a lost connection. */
  private async answered<T>(request: Promise<T>, signal: AbortSignal | null | undefined): Promise<T> {
    try {
      return await request;
    } catch (error) {
      if (!(error instanceof TypeError) || signal?.aborted) throw error;
      this.connection.lost();
      throw new ServerLost();
    }
  }
}
