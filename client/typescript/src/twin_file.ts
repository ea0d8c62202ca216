import type { Client } from './client.js';

/** Bytes of the first request, which most headers fit in. */
const FIRST = 64 << 10;
/** Headers that are larger are not read [bytes]. */
const MOST_BYTES = 16 << 20;

/** A tensor in the header of a file. */
export interface Entry {
  readonly dtype: string;
  readonly data_offsets: readonly [number, number];
}

/** The file of a twin (docs/formats/twin.md), whose data is read in parts. */
export interface OpenTwinFile {
  /** JSON document that describes the twin. */
  readonly document: unknown;
  readonly tensors: ReadonlyMap<string, Entry>;
  /** Reads bytes of the data. */
  readonly read: (from: number, to: number) => Promise<Uint8Array<ArrayBuffer>>;
}

/** Opens the file of a twin by its id: reads the header by requests for ranges. */
export async function openTwinFile(client: Client, twin: string, signal?: AbortSignal): Promise<OpenTwinFile> {
  const path = `/v1/twins/${encodeURIComponent(twin)}/content`;
  const range = async (from: number, to: number): Promise<Uint8Array<ArrayBuffer>> => {
    const answer = await client.fetch(path, { ...(signal ? { signal } : {}), headers: { range: `bytes=${from}-${to - 1}` } });
    const bytes = new Uint8Array(await answer.arrayBuffer());
    return answer.status === 206 ? bytes : bytes.slice(from, to);
  };
  let head = await range(0, FIRST);
  const start = startOfData(head);
  if (start > head.length) head = await range(0, start);
  return {
    ...readHeader(head),
    read: async (from, to) => (to > from ? range(start + from, start + to) : new Uint8Array(0)),
  };
}

/** Where the data of a file begins, of which these are the first bytes. */
export function startOfData(head: Uint8Array): number {
  const length = Number(new DataView(head.buffer, head.byteOffset).getBigUint64(0, true));
  if (length > MOST_BYTES) throw new Error('The header of the twin is too large.');
  return 8 + length;
}

/** The document and the tensors of a file that begins with these bytes. */
export function readHeader(head: Uint8Array): Pick<OpenTwinFile, 'document' | 'tensors'> {
  const text = new TextDecoder().decode(head.subarray(8, startOfData(head)));
  const { __metadata__: metadata, ...tensors } = JSON.parse(text) as Header;
  return { document: JSON.parse(metadata?.['bendtwin.twin'] ?? '{}'), tensors: new Map(Object.entries(tensors)) };
}

type Header = { readonly __metadata__?: Record<string, string> } & Record<string, Entry>;
