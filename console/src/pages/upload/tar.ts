const BLOCK = 512;
/** Sizes from here on do not fit into the eleven octal digits of a header [bytes]. */
const OCTAL_BYTES = 8 ** 11;
const ENCODER = new TextEncoder();

/** A file and its name in an archive, `/` between parts. */
export interface NamedFile {
  readonly path: string;
  readonly file: Blob;
}

/**
 * A tar archive of files, in their order, without compression.
 *
 * Composed of headers and of the files themselves, so that bytes are read only when a
 * part of it is sent. The same names and contents give the same bytes: there are no times, owners
 * or rights in it.
 */
export function tar(files: readonly NamedFile[]): Blob {
  const parts: BlobPart[] = [];
  for (const { path, file } of files) {
    parts.push(...headers(path, file.size), file, new Uint8Array(padding(file.size)));
  }
  parts.push(new Uint8Array(2 * BLOCK));
  return new Blob(parts, { type: 'application/x-tar' });
}

function headers(path: string, size: number): Uint8Array<ArrayBuffer>[] {
  const split = splitName(path);
  if (split !== null) return [header(split.name, split.prefix, size, '0')];
  const record = pathRecord(path);
  const padded = new Uint8Array(record.length + padding(record.length));
  padded.set(record);
  return [header('PaxHeader', '', record.length, 'x'), padded, header('file', '', size, '0')];
}

/** A name in the two fields that a header has for it, 100 and 155 bytes, or null if it is longer. */
function splitName(path: string): { name: string; prefix: string } | null {
  const length = (text: string): number => ENCODER.encode(text).length;
  if (length(path) <= 100) return { name: path, prefix: '' };
  for (let at = path.indexOf('/'); at > 0; at = path.indexOf('/', at + 1)) {
    const [prefix, name] = [path.slice(0, at), path.slice(at + 1)];
    if (name !== '' && length(name) <= 100 && length(prefix) <= 155) return { name, prefix };
  }
  return null;
}

/** The record of a long name: its own length in decimal, then `path=` and the name. */
function pathRecord(path: string): Uint8Array<ArrayBuffer> {
  const body = ENCODER.encode(` path=${path}\n`);
  let digits = 1;
  while (String(body.length + digits).length > digits) digits += 1;
  return ENCODER.encode(`${body.length + digits} path=${path}\n`);
}

function header(name: string, prefix: string, size: number, kind: string): Uint8Array<ArrayBuffer> {
  const block = new Uint8Array(BLOCK);
  const put = (at: number, text: string): void => block.set(ENCODER.encode(text), at);
  put(0, name);
  put(100, '0000644\0');
  put(108, '0000000\0');
  put(116, '0000000\0');
  block.set(sizeField(size), 124);
  put(136, '00000000000\0');
  put(148, '        ');
  put(156, kind);
  put(257, 'ustar\x0000');
  put(345, prefix);
  const sum = block.reduce((total, byte) => total + byte, 0);
  put(148, `${sum.toString(8).padStart(6, '0')}\0 `);
  return block;
}

/** Twelve bytes for a size: octal digits, or from 8 GiB a binary number that the first bit announces. */
export function sizeField(size: number): Uint8Array {
  if (size < OCTAL_BYTES) return ENCODER.encode(`${size.toString(8).padStart(11, '0')}\0`);
  const field = new Uint8Array(12);
  field[0] = 0x80;
  let left = size;
  for (let at = 11; at > 3; at -= 1) {
    field[at] = left % 256;
    left = Math.floor(left / 256);
  }
  return field;
}

function padding(size: number): number {
  return (BLOCK - (size % BLOCK)) % BLOCK;
}
