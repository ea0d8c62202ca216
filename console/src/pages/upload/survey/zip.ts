import { MOST_ENTRIES, bytesOf, unpacked, type Entry, type Listing } from './entries';

/** Signatures: end of the directory, the same with 64 bits and what finds it, an entry of the directory, a file. */
const END = 0x06054b50;
const END_64 = 0x06064b50;
const LOCATOR_64 = 0x07064b50;
const ENTRY = 0x02014b50;
const FILE = 0x04034b50;
/** Bytes of the end of the directory, without its comment of at most 65,535. */
const END_BYTES = 22;
const LOCATOR_BYTES = 20;
/** Largest directory that is read [bytes]: about 300,000 files. */
const MOST_BYTES = 32 * 2 ** 20;
/** Value of a field that does not hold its number, which is in 64 bits elsewhere. */
const ELSEWHERE = 0xffffffff;

/** Files of a ZIP archive, from the directory at its end: nothing else of it is read. Null without one. */
export async function listZip(file: Blob): Promise<Listing | null> {
  const place = await directoryOf(file);
  if (place === null || place.size > MOST_BYTES || place.offset + place.size > file.size) return null;
  const bytes = await bytesOf(file.slice(place.offset, place.offset + place.size));
  const view = new DataView(bytes.buffer);
  const entries: Entry[] = [];
  let at = 0;
  while (at + 46 <= bytes.length && view.getUint32(at, true) === ENTRY && entries.length < MOST_ENTRIES) {
    const [nameLength, extraLength, commentLength] = [28, 30, 32].map((field) => view.getUint16(at + field, true)) as [number, number, number];
    const name = at + 46;
    const next = name + nameLength + extraLength + commentLength;
    if (next > bytes.length) break;
    const path = new TextDecoder().decode(bytes.subarray(name, name + nameLength)).replaceAll('\\', '/');
    const extra = new DataView(bytes.buffer, name + nameLength, extraLength);
    const fields = { size: view.getUint32(at + 24, true), packed: view.getUint32(at + 20, true), offset: view.getUint32(at + 42, true) };
    if (!path.endsWith('/')) entries.push(entryOf(file, path, view.getUint16(at + 10, true), wide(fields, extra)));
    at = next;
  }
  return { entries, isWhole: at === bytes.length };
}

interface Place {
  readonly offset: number;
  readonly size: number;
}

/** Where the directory lies; null if this is no whole ZIP archive. */
async function directoryOf(file: Blob): Promise<Place | null> {
  const start = Math.max(file.size - END_BYTES - 0xffff, 0);
  const bytes = await bytesOf(file.slice(start));
  const view = new DataView(bytes.buffer);
  let at = bytes.length - END_BYTES;
  while (at >= 0 && view.getUint32(at, true) !== END) at -= 1;
  if (at < 0) return null;
  const place = { offset: view.getUint32(at + 16, true), size: view.getUint32(at + 12, true) };
  const locator = at - LOCATOR_BYTES;
  const isWide = locator >= 0 && view.getUint32(locator, true) === LOCATOR_64;
  if (!isWide) return place;
  const wideAt = Number(view.getBigUint64(locator + 8, true));
  const wideView = new DataView(await file.slice(wideAt, wideAt + 56).arrayBuffer());
  if (wideView.byteLength < 56 || wideView.getUint32(0, true) !== END_64) return null;
  return { offset: Number(wideView.getBigUint64(48, true)), size: Number(wideView.getBigUint64(40, true)) };
}

interface Fields {
  readonly size: number;
  readonly packed: number;
  readonly offset: number;
}

/** Fields of an entry, those of 64 bits from its extra fields. */
function wide(fields: Fields, extra: DataView): Fields {
  for (let at = 0; at + 4 <= extra.byteLength; at += 4 + extra.getUint16(at + 2, true)) {
    if (extra.getUint16(at, true) !== 1) continue;
    let value = at + 4;
    const end = Math.min(value + extra.getUint16(at + 2, true), extra.byteLength);
    const take = (own: number): number => {
      if (own !== ELSEWHERE || value + 8 > end) return own;
      value += 8;
      return Number(extra.getBigUint64(value - 8, true));
    };
    return { size: take(fields.size), packed: take(fields.packed), offset: take(fields.offset) };
  }
  return fields;
}

function entryOf(file: Blob, path: string, method: number, { size, packed, offset }: Fields): Entry {
  const read = async (limit: number): Promise<Uint8Array<ArrayBuffer> | null> => {
    if (size > limit || packed > limit) return null;
    const head = new DataView(await file.slice(offset, offset + 30).arrayBuffer());
    if (head.byteLength < 30 || head.getUint32(0, true) !== FILE) return null;
    const start = offset + 30 + head.getUint16(26, true) + head.getUint16(28, true);
    const part = file.slice(start, start + packed);
    if (method === 0) return bytesOf(part);
    if (method !== 8) return null;
    const { bytes, isWhole } = await unpacked(part, 'deflate-raw', limit);
    return isWhole ? bytes : null;
  };
  return { path, size, read };
}
