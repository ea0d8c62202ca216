/** Kind of a file, by its content; `motion` is motion capture as arrays, which has to be converted first. */
export type Content = 'capture' | 'twin' | 'motion' | 'other';

/** Bytes by which a file is recognised, as by the server. */
const LOOKED_AT = 2048;

/** Reads the first bytes of a file. */
export async function contentOf(file: File): Promise<Content> {
  if (/\.npz$/i.test(file.name)) return 'motion';
  const bytes = new Uint8Array(await file.slice(0, LOOKED_AT).arrayBuffer());
  if (isTwin(bytes, file.size)) return 'twin';
  const isArchive = MARKS.some(([at, mark]) => mark.every((byte, index) => bytes[at + index] === byte));
  return isArchive || isMarkers(bytes) ? 'capture' : 'other';
}

/** ZIP, gzip, tar, MCAP and Zstandard: where their mark lies, and its bytes. */
const MARKS: readonly (readonly [number, readonly number[]])[] = [
  [0, [0x50, 0x4b, 0x03, 0x04]],
  [0, [0x1f, 0x8b]],
  [257, [0x75, 0x73, 0x74, 0x61, 0x72]],
  [0, [0x89, 0x4d, 0x43, 0x41, 0x50]],
  [0, [0x28, 0xb5, 0x2f, 0xfd]],
];

/** Markers of motion capture: the CSV of OptiTrack's Motive, TRC, or C3D. */
function isMarkers(bytes: Uint8Array<ArrayBuffer>): boolean {
  // The decoder takes a byte order mark away.
  const text = new TextDecoder().decode(bytes);
  if (text.startsWith('Format Version,') || text.startsWith('PathFileType')) return true;
  // C3D begins with the number of the block of its parameters, whose fourth byte is that of a processor.
  const [block = 0, key] = bytes;
  const processor = bytes[512 * (block - 1) + 3] ?? 0;
  return key === 0x50 && block >= 2 && processor >= 84 && processor <= 86;
}

/** A twin is a safetensors file: the length of its JSON header, then the header. */
function isTwin(bytes: Uint8Array<ArrayBuffer>, size: number): boolean {
  if (bytes.length < 9 || bytes[8] !== 0x7b) return false;
  const length = new DataView(bytes.buffer).getBigUint64(0, true);
  return length > 1n && length < BigInt(size);
}

/** Files that people take for captures, or drop by mistake: where their mark lies, the mark, and words for them. */
const OTHERS: readonly (readonly [number, string, string])[] = [
  [0, 'MZ', 'a Windows program'],
  [0, '\x7fELF', 'a Linux program'],
  [0, '%PDF', 'a PDF document'],
  [0, '\x89PNG', 'an image'],
  [0, '\xff\xd8\xff', 'an image'],
  [0, 'GIF8', 'an image'],
  [4, 'ftyp', 'a video'],
  [0, '\x1aE\xdf\xa3', 'a video'],
  [8, 'AVI ', 'a video'],
  [0, '7z\xbc\xaf', 'a 7z archive'],
  [0, 'Rar!', 'a RAR archive'],
  [0, '\x89HDF', 'an HDF5 file'],
  [0, '#ROSBAG', 'a bag of ROS 1'],
  [0, 'SQLite format 3', 'a database, as of ROS 2'],
  [0, 'glTF', 'a mesh'],
  [0, 'ply\n', 'a mesh or a cloud of points'],
];

/** What a file is that is no capture, in words; null if that is unknown. */
export async function kindOf(file: File): Promise<string | null> {
  const bytes = new Uint8Array(await file.slice(0, 32).arrayBuffer());
  const text = String.fromCharCode(...bytes);
  if (bytes.length === 0) return 'empty';
  return OTHERS.find(([at, mark]) => text.startsWith(mark, at))?.[2] ?? null;
}

/** Advice for files that are neither a capture nor a twin, or null. `kind` says what they are, if that is known. */
export function refusal(name: string, content: Content, kind: string | null = null): string | null {
  if (content === 'motion') {
    return `${name} is motion capture, which the command bendtwin capture push converts and sends.`;
  }
  if (content === 'other') {
    if (/\.json$/i.test(name)) {
      const added = "or, if it is a calibration.json, add it on the capture's page";
      return `${name} alone is not a capture: drop the folder that it belongs to, ${added}.`;
    }
    const taken =
      'a folder, an archive (.zip, .tar, .tar.gz), an .mcap file, markers (.c3d, .csv of OptiTrack, .trc), or a twin file';
    return `${name} is ${kind === null ? 'not a capture' : `${kind}, not a capture`}: send ${taken}.`;
  }
  return null;
}
