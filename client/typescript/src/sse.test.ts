import { describe, expect, it } from 'vitest';
import { Parser, messages } from './sse.js';

const STREAM = ': alive\n\nevent: fit\nid: 3\ndata: {"a":1}\n\nevent: fit\r\nid: 4\r\ndata: one\r\ndata:two\r\n\r\ndata: 🙂\n\n';
const EXPECTED = [
  { event: 'fit', id: '3', data: '{"a":1}' },
  { event: 'fit', id: '4', data: 'one\ntwo' },
  { event: 'message', id: '4', data: '🙂' },
];

describe('Parser', () => {
  it('reads messages whole, and cut at every place', () => {
    expect([...new Parser().push(STREAM)]).toEqual(EXPECTED);
    for (let at = 0; at <= STREAM.length; at += 1) {
      const parser = new Parser();
      const parts = [STREAM.slice(0, at), STREAM.slice(at)];
      expect(parts.flatMap((part) => [...parser.push(part)])).toEqual(EXPECTED);
    }
  });

  it('gives nothing of a message that is not whole', () => {
    expect([...new Parser().push('data: half')]).toEqual([]);
    expect([...new Parser().push('data: half\n')]).toEqual([]);
  });
});

describe('messages', () => {
  it('reads bytes that are cut within a character', async () => {
    const bytes = new TextEncoder().encode(STREAM);
    const body = new ReadableStream<Uint8Array<ArrayBuffer>>({
      start(controller) {
        for (const byte of bytes) controller.enqueue(new Uint8Array([byte]));
        controller.close();
      },
    });
    const read = [];
    for await (const message of messages(new Response(body))) read.push(message);
    expect(read).toEqual(EXPECTED);
  });
});
