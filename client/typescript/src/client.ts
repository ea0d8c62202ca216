import { Connection, ServerLost } from './connection.js';
import { watch } from './events.js';
import { Problem, problemOf } from './problem.js';
import { addressOf, type Given, type Path, type Reply, type Verb } from './routes.js';
import { messages } from './sse.js';
import { hasEnded, type Capture, type Fit } from './types.js';

/** Statuses with which a proxy says that there is no server behind it. */
const NO_SERVER = [502, 504];

/** An answer of the server itself. */
const UNCACHED: RequestInit & { readonly cache: 'no-store' } = { cache: 'no-store' };

export interface ClientOptions {
  /** Address of the server, such as `http://127.0.0.1:7070`; in a browser by default the one that the page came from. */
  readonly address?: string;
  /** Token or key that requests show; a function is asked before each request, and null means none. */
  readonly token?: string | null | (() => string | null);
  /** Takes the place of `fetch`, for example to trust a certificate authority. */
  readonly fetch?: typeof fetch;
}

/** Arguments of any route. */
interface AnyArguments {
  readonly id?: string;
  readonly query?: object;
  readonly body?: unknown;
  readonly key?: string;
  readonly signal?: AbortSignal;
}

/** Requests to a server. Routes are those of its `/openapi.json`, and so are the types of bodies and answers. */
export class Client {
  /** Says whether the server answers. */
  readonly connection: Connection;

  /** Called when an answer asks for a token, or for another one. */
  onUnauthenticated: (problem: Problem) => void = () => undefined;

  readonly #address: string;
  readonly #token: () => string | null;
  readonly #fetch: typeof fetch;

  constructor({ address = '', token = null, fetch: given }: ClientOptions = {}) {
    this.#address = address.replace(/\/+$/, '');
    this.#token = typeof token === 'function' ? token : () => token;
    // The function of the time of the call: pages and tests may replace it.
    this.#fetch = given ?? ((...request) => fetch(...request));
    this.connection = new Connection(async () => {
      try {
        return !NO_SERVER.includes((await this.#fetch(`${this.#address}/healthz`, UNCACHED)).status);
      } catch {
        return false;
      }
    });
  }

  /** The answer of a route to GET. */
  get<P extends Path<'get'>>(route: P, ...[given]: Given<P, 'get'>): Promise<Reply<P, 'get'>> {
    return this.call('get', route, given);
  }

  /** The answer of a route to POST. */
  post<P extends Path<'post'>>(route: P, ...[given]: Given<P, 'post'>): Promise<Reply<P, 'post'>> {
    return this.call('post', route, given);
  }

  /** The answer of a route to PATCH. */
  patch<P extends Path<'patch'>>(route: P, ...[given]: Given<P, 'patch'>): Promise<Reply<P, 'patch'>> {
    return this.call('patch', route, given);
  }

  /** Deletes a resource by its name, such as `fits/0199…`: captures, fits and twins go to the trash. */
  async delete(name: string, { signal }: { signal?: AbortSignal } = {}): Promise<void> {
    await this.fetch(`/v1/${name}`, { method: 'DELETE', ...(signal ? { signal } : {}) });
  }

  /** Uploads a recording: the bytes of a ZIP or tar archive, or of another file of a capture. */
  uploadCapture(
    content: Blob | ArrayBuffer | Uint8Array,
    { displayName = '', signal }: { displayName?: string; signal?: AbortSignal } = {},
  ): Promise<Capture> {
    const path = addressOf('/v1/captures', undefined, { display_name: displayName });
    const headers = { 'content-type': 'application/octet-stream' };
    return this.json(path, { method: 'POST', headers, body: content as ArrayBuffer, ...(signal ? { signal } : {}) });
  }

  /** The states of a capture while it is read, by its name; the last has `ingest` ended. */
  watchCapture(name: string, options: { signal?: AbortSignal } = {}): AsyncGenerator<Capture> {
    const isLast = ({ ingest }: Capture): boolean => ingest === undefined || hasEnded(ingest);
    return watch(this, `/v1/${name}/events`, { ...options, isLast });
  }

  /** The states of a fit while it runs, by its name; the last has `job` ended. */
  watchFit(name: string, options: { signal?: AbortSignal } = {}): AsyncGenerator<Fit> {
    return watch(this, `/v1/${name}/events`, { ...options, isLast: ({ job }: Fit) => hasEnded(job) });
  }

  /** The messages of an answer that is a stream of events, as of `/v1/plans`; throws the problem that ends it. */
  async *stream<T>(path: string, body: unknown, { signal }: { signal?: AbortSignal } = {}): AsyncGenerator<T> {
    const headers = { accept: 'text/event-stream', 'content-type': 'application/json' };
    const request = { method: 'POST', headers, body: JSON.stringify(body), ...(signal ? { signal } : {}) };
    for await (const { event, data } of messages(await this.fetch(path, request))) {
      if (event === 'error') throw Problem.read(data);
      yield JSON.parse(data) as T;
    }
  }

  /** Answers with JSON, or throws a `Problem`, or `ServerLost`. */
  async json<T>(path: string, options: RequestInit = {}): Promise<T> {
    const answer = await this.fetch(path, options);
    return this.answered(answer.json() as Promise<T>, options.signal);
  }

  /** The answer itself, for streams and bytes; throws a `Problem` if it refuses, and `ServerLost`. */
  async fetch(path: string, options: RequestInit = {}): Promise<Response> {
    const headers = new Headers(options.headers);
    const shown = this.#token();
    if (shown !== null) headers.set('authorization', `Bearer ${shown}`);
    // Without the browser's credentials there is no password prompt at a 401.
    const request = this.#fetch(this.#address + path, { ...options, headers, credentials: 'omit' });
    const answer = await this.answered(request, options.signal);
    if (answer.ok) {
      this.connection.answered();
      return answer;
    }
    const problem = await problemOf(answer);
    if (problem.status === 401) this.onUnauthenticated(problem);
    if (NO_SERVER.includes(problem.status) && problem.reason === '') {
      this.connection.lost();
      throw new ServerLost();
    }
    throw problem;
  }

  private call<T>(verb: Verb, route: string, { id, query, body, key, signal }: AnyArguments = {}): Promise<T> {
    const headers = { 'content-type': 'application/json', ...(key === undefined ? {} : { 'idempotency-key': key }) };
    const request = verb === 'get' ? {} : { method: verb.toUpperCase(), headers, body: JSON.stringify(body ?? {}) };
    return this.json(addressOf(route, id, query), signal === undefined ? request : { ...request, signal });
  }

  /** Result of a request or a body, with the one error that `fetch` has for a lost connection. */
  private async answered<T>(request: Promise<T>, signal: AbortSignal | null | undefined): Promise<T> {
    try {
      return await request;
    } catch (error) {
      if (!(error instanceof TypeError) || signal?.aborted) throw error;
      this.connection.lost();
      throw new ServerLost({ cause: error });
    }
  }
}
