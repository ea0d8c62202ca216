/** Kind of a file, by its content; `motion` is motion capture, which has to be converted first. */
export type Content = 'capture' | 'twin' | 'motion' | 'other';

/** Reads the first bytes of a file. */
export async function contentOf(file: File): Promise<Content> {
  if (/\.npz$/i.test(file.name)) return 'motion';
  const bytes = new Uint8Array(await file.slice(0, 512).arrayBuffer());
  if (isTwin(bytes, file.size)) return 'twin';
  return MARKS.some(([at, mark]) => mark.every((byte, index) => bytes[at + index] === byte)) ? 'capture' : 'other';
}

/** ZIP, gzip, tar, MCAP and Zstandard: where their mark lies, and its bytes. */
const MARKS: readonly (readonly [number, readonly number[]])[] = [
  [0, [0x50, 0x4b, 0x03, 0x04]],
  [0, [0x1f, 0x8b]],
  [257, [0x75, 0x73, 0x74, 0x61, 0x72]],
  [0, [0x89, 0x4d, 0x43, 0x41, 0x50]],
  [0, [0x28, 0xb5, 0x2f, 0xfd]],
];

/** A twin is a safetensors file: the length of its JSON header, then the header. */
function isTwin(bytes: Uint8Array<ArrayBuffer>, size: number): boolean {
  if (bytes.length < 9 || bytes[8] !== 0x7b) return false;
  const length = new DataView(bytes.buffer).getBigUint64(0, true);
  return length > 1n && length < BigInt(size);
}

/** Advice for files that are neither a capture nor a twin, or null. */
export function refusal(name: string, content: Content): string | null {
  if (content === 'motion') {
    return `${name} is motion capture, which the command bendtwin capture push converts and sends.`;
  }
  if (content === 'other') {
    const taken = 'a folder, an archive (.zip, .tar, .tar.gz), an .mcap file, or a twin file';
    return `${name} is not a capture: send ${taken}.`;
  }
  return null;
}
