import { describe, expect, it } from 'vitest';
import type { Api } from '../../api/client';
import { PlaybackFile } from './file';
import { hasSeveralRecordings, readHead } from './head';
import { camera, fileOf, int16, sequence } from '../testing';
import { Motion } from './motion';

/** A server of one file that answers to ranges, and the ranges that it was asked for. */
function serverOf(bytes: Uint8Array<ArrayBuffer>): { api: Api; asked: string[]; tag: string } {
  const server = { api: {} as Api, asked: [] as string[], tag: '"a"' };
  server.api.fetch = (_path, options) => {
    const range = new Headers(options?.headers).get('range') ?? '';
    server.asked.push(range);
    const [first = 0, last = 0] = range.replace('bytes=', '').split('-').map(Number);
    const part = bytes.slice(first, last + 1);
    return Promise.resolve(new Response(part, { status: 206, headers: { etag: server.tag } }));
  };
  return server;
}

const DATA = new Uint8Array([
  ...int16(0, 0, 0, 100, -200, 300, 1, 1, 1, -32768, -32768, -32768),
  0b11, 0b01,
  ...int16(500, 0, 0, 600, 0, 0),
]);

describe('a playback', () => {
  it('of several recordings is known by their numbers', () => {
    const of = (...recordings: number[]): boolean =>
      hasSeveralRecordings({ name: 'toy', left_out: 0, sequences: recordings.map((recording) => sequence({ recording })) });
    expect([of(), of(0), of(0, 0), of(0, 1)]).toEqual([false, false, false, true]);
  });

  it('is read by ranges, and its points are where they were', async () => {
    const server = serverOf(fileOf({ sequences: [sequence()], left_out: 0, name: 'toy' }, DATA));
    const file = await PlaybackFile.open(server.api, 'id', new AbortController().signal);
    const head = file.head.sequences[0]!;
    const motion = new Motion(head.motion, head.frame_count, file.read.bind(file));
    expect(motion.frame(0)).toBeNull();
    await motion.load(0);
    const [first, second] = [motion.frame(0)!, motion.frame(1)!];
    const rounded = (values: Float32Array): number[] => Array.from(values, (x) => Math.round(1000 * x));
    expect(rounded(first.points)).toEqual([1000, 0, 0, 1100, -200, 300]);
    expect([...first.visible, ...second.visible]).toEqual([1, 1, 1, 0]);
    expect(rounded(second.points.subarray(0, 3))).toEqual([1001, 1, 1]);
    expect(second.points[3]).toBeNaN();
    expect(rounded(second.controls)).toEqual([1600, 0, 0]);
    // The head, and the three arrays once.
    await motion.load(1);
    expect(server.asked).toHaveLength(4);
  });

  it('with a long head takes another request', async () => {
    const name = 'n'.repeat(70_000);
    const server = serverOf(fileOf({ sequences: [sequence({ name })], left_out: 0 }, DATA));
    const file = await PlaybackFile.open(server.api, 'id', new AbortController().signal);
    expect(file.head.sequences[0]!.name).toBe(name);
    expect(Array.from(await file.read([24, 2]))).toEqual([3, 1]);
  });

  it('that was replaced is not mixed with the previous one', async () => {
    const server = serverOf(fileOf({ sequences: [sequence()], left_out: 0 }, DATA));
    const file = await PlaybackFile.open(server.api, 'id', new AbortController().signal);
    server.tag = '"b"';
    await expect(file.read([0, 4])).rejects.toThrow('read again');
  });

  it('that contradicts itself is refused', () => {
    const read = (changes: Parameters<typeof sequence>[0]): unknown =>
      readHead(new TextEncoder().encode(JSON.stringify({ sequences: [sequence(changes)] })));
    expect(read({})).toBeDefined();
    expect(() => read({ frame_count: 3 })).toThrow('24 bytes of points in place of 36');
    expect(() => read({ fps: 0 })).toThrow('without frames');
    const images = { size: [1, 1], every: 1, lengths: [5, 6], bytes: [0, 12] } as const;
    expect(() => read({ cameras: [camera({ images })] })).toThrow('12 bytes of images in place of 11');
    const one = { images: { size: [1, 1], every: 1, lengths: [6], bytes: [0, 6] } } as const;
    const masks = { lengths: [2], bytes: [6, 2] } as const;
    expect(read({ cameras: [camera({ ...one, masks, doubt: [0, null] })] })).toBeDefined();
    expect(() => read({ cameras: [camera({ ...one, masks: { ...masks, lengths: [3] } })] })).toThrow('bytes of masks');
    const several = { lengths: [1, 1], bytes: [6, 2] } as const;
    expect(() => read({ cameras: [camera({ ...one, masks: several })] })).toThrow('2 lengths of masks in place of 1');
    expect(() => read({ cameras: [camera({ ...one, doubt: [0] })] })).toThrow('1 values of doubt in place of 2');
    // Without a calibration there are no poses.
    expect(read({ cameras: [camera({ ...one, poses: [0, 0] })] })).toBeDefined();
    expect(() => readHead(new TextEncoder().encode('{}'))).toThrow('no sequences');
  });

  it('of another kind is refused', async () => {
    const server = serverOf(new TextEncoder().encode('<!doctype html><p>nothing'));
    await expect(PlaybackFile.open(server.api, 'id', new AbortController().signal)).rejects.toThrow('not a playback');
  });
});
