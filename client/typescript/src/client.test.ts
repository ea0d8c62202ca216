import { afterEach, describe, expect, it, vi } from 'vitest';
import { Client } from './client.js';
import { ServerLost } from './connection.js';
import { Problem } from './problem.js';

/** A client whose requests get these answers in turn, and the requests. */
function clientOf(...answers: (Response | Error)[]): { client: Client; sent: { address: string; options: RequestInit }[] } {
  const sent: { address: string; options: RequestInit }[] = [];
  const answer = async (address: string | URL | Request, options: RequestInit = {}): Promise<Response> => {
    sent.push({ address: String(address), options });
    const next = answers.shift() ?? new Response('ok');
    if (next instanceof Error) throw next;
    return next;
  };
  return { client: new Client({ address: 'http://twin.example/', token: 'abc', fetch: answer }), sent };
}

describe('Client', () => {
  afterEach(() => vi.unstubAllGlobals());

  it('fills in a route, and shows its token', async () => {
    const { client, sent } = clientOf(Response.json({ fits: [] }));
    const reply = await client.get('/v1/fits', { query: { search: 'rope', page_size: 3 } });
    expect(reply.fits).toEqual([]);
    expect(sent[0]?.address).toBe('http://twin.example/v1/fits?search=rope&page_size=3');
    expect(new Headers(sent[0]?.options.headers).get('authorization')).toBe('Bearer abc');
  });

  it('sends a body as JSON, repeatably', async () => {
    const { client, sent } = clientOf(Response.json({ name: 'fits/1' }, { status: 202 }), Response.json({}));
    const fit = await client.post('/v1/fits', { key: 'once', body: { capture: 'captures/1' } });
    await client.patch('/v1/fits/{id}', { id: '1', body: { note: 'wet' } });
    expect(fit.name).toBe('fits/1');
    expect(sent.map(({ options }) => [options.method, options.body])).toEqual([
      ['POST', '{"capture":"captures/1"}'],
      ['PATCH', '{"note":"wet"}'],
    ]);
    expect(new Headers(sent[0]?.options.headers).get('idempotency-key')).toBe('once');
  });

  it('asks for its token before each request', async () => {
    const tokens = ['a', null];
    const shown: (string | null)[] = [];
    vi.stubGlobal('fetch', async (_: string, options: RequestInit) => {
      shown.push(new Headers(options.headers).get('authorization'));
      return Response.json({ workers: [] });
    });
    const client = new Client({ token: () => tokens.shift() ?? null });
    await client.get('/v1/workers');
    await client.get('/v1/workers');
    expect(shown).toEqual(['Bearer a', null]);
  });

  it('throws what the server refuses with, and says when it wants a token', async () => {
    const body = JSON.stringify({ status: 401, reason: 'NO_TOKEN', detail: 'show a token', request_id: 'r1' });
    const { client } = clientOf(new Response(body, { status: 401 }));
    const asked = vi.fn();
    client.onUnauthenticated = asked;
    const refused = client.get('/v1/workers');
    await expect(refused).rejects.toMatchObject({ reason: 'NO_TOKEN', message: 'show a token', requestId: 'r1' });
    expect(asked).toHaveBeenCalledOnce();
  });

  it('tells a lost server from one that refuses', async () => {
    const { client } = clientOf(new TypeError('fetch failed'), new Response('bad gateway', { status: 502 }), Response.json({}));
    await expect(client.get('/v1/workers')).rejects.toBeInstanceOf(ServerLost);
    expect(client.connection.isLost).toBe(true);
    await expect(client.get('/v1/workers')).rejects.toBeInstanceOf(ServerLost);
    await client.get('/v1/workers');
    expect(client.connection.isLost).toBe(false);
  });

  it('reads a stream up to the problem that ends it', async () => {
    const problem = JSON.stringify({ status: 409, reason: 'SESSION_LOST', detail: 'open another' });
    const { client } = clientOf(new Response(`data: {"n":1}\n\nevent: error\ndata: ${problem}\n\n`));
    const got: unknown[] = [];
    const read = async (): Promise<void> => {
      for await (const message of client.stream('/v1/plans', {})) got.push(message);
    };
    const error = await read().catch((thrown: unknown) => thrown);
    expect(got).toEqual([{ n: 1 }]);
    expect(error).toBeInstanceOf(Problem);
    expect(error).toMatchObject({ status: 409, reason: 'SESSION_LOST' });
  });
});
