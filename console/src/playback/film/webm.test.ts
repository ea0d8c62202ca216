import { expect, it } from 'vitest';
import { webm, type Packet } from './webm';

interface Element {
  readonly id: string;
  /** First byte of the element, and of its content. */
  readonly at: number;
  readonly from: number;
  readonly content: Uint8Array;
}

/** The elements in some bytes, read by the rules of EBML. */
function elements(bytes: Uint8Array, base = 0): Element[] {
  const found: Element[] = [];
  for (let at = 0; at < bytes.length; ) {
    const idLength = Math.clz32(bytes[at]!) - 23;
    const sizeAt = at + idLength;
    const sizeLength = Math.clz32(bytes[sizeAt]!) - 23;
    const size = bytes.subarray(sizeAt + 1, sizeAt + sizeLength).reduce((sum, byte) => 256 * sum + byte, 0);
    const from = sizeAt + sizeLength;
    const id = [...bytes.subarray(at, sizeAt)].map((byte) => byte.toString(16).padStart(2, '0')).join('');
    found.push({ id, at: base + at, from: base + from, content: bytes.subarray(from, from + size) });
    at = from + size;
  }
  return found;
}

const value = (bytes: Uint8Array): number => bytes.reduce((sum, byte) => 256 * sum + byte, 0);
const inside = (element: Element): Element[] => elements(element.content, element.from);

it('is a file with a track, an index of its keys, and all packets at their times', async () => {
  const packets: Packet[] = [0, 33, 67, 100].map((timeMs, i) => {
    return { data: new Uint8Array([i, i]), timeMs, isKey: i === 0 || i === 2 };
  });
  const file = webm(packets, { codec: 'V_VP8', width: 640, height: 360, durationMs: 133 });
  const bytes = new Uint8Array(await file.arrayBuffer());
  const [head, segment, ...others] = elements(bytes);
  expect([head!.id, segment!.id, others]).toEqual(['1a45dfa3', '18538067', []]);
  expect(new TextDecoder().decode(inside(head!)[4]!.content)).toBe('webm');
  const parts = inside(segment!);
  expect(parts.map(({ id }) => id)).toEqual(['1549a966', '1654ae6b', '1c53bb6b', '1f43b675', '1f43b675']);
  const [info, tracks, cues, ...clusters] = parts;
  const duration = inside(info!).find(({ id }) => id === '4489')!.content;
  expect(new DataView(duration.slice().buffer).getFloat64(0)).toBe(133);
  const track = inside(inside(tracks!)[0]!);
  expect(new TextDecoder().decode(track.find(({ id }) => id === '86')!.content)).toBe('V_VP8');
  expect(inside(track.find(({ id }) => id === 'e0')!).map(({ content }) => value(content))).toEqual([640, 360]);
  const points = inside(cues!).map((point) => {
    const [time, place] = inside(point);
    return [value(time!.content), value(inside(place!)[1]!.content)];
  });
  expect(points).toEqual([[0, clusters[0]!.at - segment!.from], [67, clusters[1]!.at - segment!.from]]);
  const blocks = clusters.flatMap((cluster) => {
    const [start, ...own] = inside(cluster);
    return own.map(({ content }) => [value(start!.content) + value(content.subarray(1, 3)), content[3]! >> 7, content[4]]);
  });
  expect(blocks).toEqual([[0, 1, 0], [33, 0, 1], [67, 1, 2], [100, 0, 3]]);
});
