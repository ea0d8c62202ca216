/** A WebM file of one video track without sound: https://www.matroska.org/technical/elements.html. */

/** An encoded picture. */
export interface Packet {
  readonly data: Uint8Array<ArrayBuffer>;
  /** When it is shown, from the start [ms]. */
  readonly timeMs: number;
  /** True if it needs no picture before it. */
  readonly isKey: boolean;
}

export interface Track {
  readonly codec: 'V_VP8' | 'V_VP9';
  /** [pixels] */
  readonly width: number;
  readonly height: number;
  readonly durationMs: number;
}

type Part = Uint8Array<ArrayBuffer>;

/** The file of packets, in the order of their times, of which the first is a key. It can be sought by its keys. */
export function webm(packets: readonly Packet[], track: Track): Blob {
  const groups: Packet[][] = [];
  for (const packet of packets) {
    if (packet.isKey || groups.length === 0) groups.push([]);
    groups.at(-1)!.push(packet);
  }
  const clusters = groups.map(cluster);
  const head = [info(track), tracks(track)];
  // The length of the index does not depend on the places in it.
  const start = length(head) + cues(groups, groups.map(() => 0)).length;
  let at = start;
  const places = clusters.map((parts) => (at += length(parts)) - length(parts));
  const body = [...head, cues(groups, places), ...clusters.flat()];
  return new Blob([header(), opening(0x18538067, length(body)), ...body], { type: 'video/webm' });
}

function header(): Part {
  return element(0x1a45dfa3,
    number(0x4286, 1), number(0x42f7, 1), number(0x42f2, 4), number(0x42f3, 8),
    text(0x4282, 'webm'), number(0x4287, 2), number(0x4285, 2));
}

/** Times are in milliseconds: 1,000,000 ns. */
function info({ durationMs }: Track): Part {
  const duration = new Uint8Array(8);
  new DataView(duration.buffer).setFloat64(0, durationMs);
  return element(0x1549a966,
    number(0x2ad7b1, 1_000_000), text(0x4d80, 'BendTwin'), text(0x5741, 'BendTwin'), element(0x4489, duration));
}

function tracks({ codec, width, height }: Track): Part {
  const video = element(0xe0, number(0xb0, width), number(0xba, height));
  return element(0x1654ae6b,
    element(0xae, number(0xd7, 1), number(0x73c5, 1), number(0x83, 1), text(0x86, codec), video));
}

/** The index: times of groups, and where their clusters are, from the first byte of the segment's content. */
function cues(groups: readonly Packet[][], places: readonly number[]): Part {
  const points = groups.map(([first], i) => {
    const place = element(0xb7, number(0xf7, 1), number(0xf1, places[i]!));
    return element(0xbb, number(0xb3, first!.timeMs), place);
  });
  return element(0x1c53bb6b, ...points);
}

/** A group of packets, as parts so that data is not copied. */
function cluster(packets: readonly Packet[]): Part[] {
  const start = Math.round(packets[0]!.timeMs);
  const blocks = packets.flatMap(({ data, timeMs, isKey }) => {
    const head = new Uint8Array([0x81, 0, 0, isKey ? 0x80 : 0]);
    new DataView(head.buffer).setInt16(1, Math.round(timeMs) - start);
    return [opening(0xa3, head.length + data.length), head, data];
  });
  const content = [number(0xe7, start), ...blocks];
  return [opening(0x1f43b675, length(content)), ...content];
}

function element(id: number, ...content: Part[]): Part {
  const parts = [opening(id, length(content)), ...content];
  const all = new Uint8Array(length(parts));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

/** The bytes before the content of an element: its id, which tells its own length, and the length of the content. */
function opening(id: number, contentLength: number): Part {
  const idLength = Math.ceil(Math.log2(id + 1) / 8);
  const bytes = new Uint8Array(idLength + 8);
  for (let i = 0; i < idLength; i += 1) bytes[i] = (id / 256 ** (idLength - 1 - i)) & 0xff;
  // A one after seven zeros: the length has eight bytes.
  new DataView(bytes.buffer).setBigUint64(idLength, (1n << 56n) | BigInt(contentLength));
  return bytes;
}

/** An element with a whole number, below 2^32. */
function number(id: number, value: number): Part {
  const bytes = new Uint8Array(4);
  new DataView(bytes.buffer).setUint32(0, Math.round(value));
  return element(id, bytes);
}

function text(id: number, value: string): Part {
  return element(id, new TextEncoder().encode(value));
}

function length(parts: readonly Part[]): number {
  return parts.reduce((sum, part) => sum + part.length, 0);
}
