import { MOST_ENTRIES, bytesOf, entryOf, unpacked, type Entry, type Listing } from './entries';

const BLOCK = 512;
/** Bytes that are read together: small files lie between heads. */
const WINDOW = 2 ** 16;
/** Longest name that is read [bytes]. */
const MOST_NAME = 2 ** 16;
/** Longest time for the heads of an archive [ms]. */
const MOST_MS = 4000;
/** Bytes of a compressed archive that are unpacked, and what they may unpack to. */
const PACKED_BYTES = 4 * 2 ** 20;
const UNPACKED_BYTES = 32 * 2 ** 20;

/** Files of a tar archive, from the heads before them: what lies between is skipped. Null if it begins otherwise. */
export async function listTar(file: Blob): Promise<Listing | null> {
  const began = performance.now();
  const entries: Entry[] = [];
  let window = { from: 0, bytes: new Uint8Array(0) };
  let longName: string | null = null;
  let at = 0;
  while (at + BLOCK <= file.size) {
    if (entries.length >= MOST_ENTRIES || performance.now() - began > MOST_MS) return { entries, isWhole: false };
    if (at < window.from || at + BLOCK > window.from + window.bytes.length) {
      window = { from: at, bytes: await bytesOf(file.slice(at, at + WINDOW)) };
    }
    const head = window.bytes.subarray(at - window.from, at - window.from + BLOCK);
    // Two empty blocks end an archive.
    if (head.every((byte) => byte === 0)) return { entries, isWhole: true };
    if (!isHead(head)) return entries.length > 0 ? { entries, isWhole: false } : null;
    const size = sizeOf(head);
    const [start, kind] = [at + BLOCK, String.fromCharCode(head[156] ?? 0)];
    at = start + Math.ceil(size / BLOCK) * BLOCK;
    if (kind === 'x' || kind === 'L') {
      longName = size > MOST_NAME ? null : nameIn(await bytesOf(file.slice(start, start + size)), kind);
    } else {
      const path = (longName ?? pathOf(head)).replace(/^\.\//, '');
      if (kind === '0' || kind === '\0') entries.push(entryOf(path, file.slice(start, start + size)));
      longName = null;
    }
  }
  return { entries, isWhole: at >= file.size };
}

/** Files at the beginning of a tar archive that is compressed with gzip. */
export async function listTarGz(file: Blob): Promise<Listing | null> {
  const { bytes, isWhole } = await unpacked(file.slice(0, PACKED_BYTES), 'gzip', UNPACKED_BYTES);
  const listing = await listTar(new Blob([bytes]));
  return listing === null ? null : { entries: listing.entries, isWhole: isWhole && listing.isWhole };
}

function isHead(head: Uint8Array): boolean {
  const sum = head.reduce((total, byte, index) => total + (index >= 148 && index < 156 ? 0x20 : byte), 0);
  return Number.parseInt(text(head, 148, 8), 8) === sum;
}

/** Octal digits, or a binary number that the first bit announces. */
function sizeOf(head: Uint8Array): number {
  if (((head[124] ?? 0) & 0x80) === 0) return Number.parseInt(text(head, 124, 12), 8) || 0;
  return head.subarray(125, 136).reduce((total, byte) => total * 256 + byte, 0);
}

function pathOf(head: Uint8Array): string {
  const prefix = text(head, 257, 5) === 'ustar' ? text(head, 345, 155) : '';
  return prefix === '' ? text(head, 0, 100) : `${prefix}/${text(head, 0, 100)}`;
}

/** A name that stands before its file: a record `path=` of pax, or a text of GNU. */
function nameIn(bytes: Uint8Array, kind: 'x' | 'L'): string | null {
  if (kind === 'L') return text(bytes, 0, bytes.length);
  return /(?:^|\n)\d+ path=([^\n]*)\n/.exec(new TextDecoder().decode(bytes))?.[1] ?? null;
}

/** The text of a field, up to its first zero. */
function text(bytes: Uint8Array, from: number, length: number): string {
  const field = bytes.subarray(from, from + length);
  const end = field.indexOf(0);
  return new TextDecoder().decode(end < 0 ? field : field.subarray(0, end)).trim();
}
