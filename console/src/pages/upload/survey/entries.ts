/** A file of an archive or a folder that is about to be sent: its path, `/` between parts, and how its bytes are read. */
export interface Entry {
  readonly path: string;
  /** Size [bytes]. */
  readonly size: number;
  /** The bytes of the file, up to a limit; null if they are more, or cannot be read here. */
  readonly read: (limit: number) => Promise<Uint8Array<ArrayBuffer> | null>;
}

/** Entries of an archive; `isWhole` is false if it was looked into only in part. */
export interface Listing {
  readonly entries: readonly Entry[];
  readonly isWhole: boolean;
}

/** Most entries that are looked at. */
export const MOST_ENTRIES = 200_000;

/** An entry of a file that lies in a folder. */
export function entryOf(path: string, file: Blob): Entry {
  return { path, size: file.size, read: (limit) => (file.size > limit ? Promise.resolve(null) : bytesOf(file)) };
}

export async function bytesOf(part: Blob): Promise<Uint8Array<ArrayBuffer>> {
  return new Uint8Array(await part.arrayBuffer());
}

/**
 * What a compressed part unpacks to, up to a limit of bytes. A part that is damaged, or cut off, gives what was
 * unpacked before; `isWhole` is true if that is all.
 */
export async function unpacked(
  part: Blob,
  format: CompressionFormat,
  limit: number,
): Promise<{ bytes: Uint8Array<ArrayBuffer>; isWhole: boolean }> {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let size = 0;
  let isWhole = false;
  const reader = part.stream().pipeThrough(new DecompressionStream(format)).getReader();
  try {
    for (;;) {
      const { done, value } = await reader.read();
      if (done) {
        isWhole = true;
        break;
      }
      parts.push(value);
      size += value.length;
      if (size > limit) break;
    }
  } catch {
    // Cut off here.
  }
  void reader.cancel().catch(() => undefined);
  return { bytes: await bytesOf(new Blob(parts)), isWhole };
}
