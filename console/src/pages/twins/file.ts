import type { Api } from '../../api/client';

/** Headers that are larger are not read [bytes]. */
const MOST_BYTES = 16 * 2 ** 20;

/** Parts of a twin's file (docs/formats/twin.md), read without loading all of it. */
export interface TwinFile {
  readonly document: TwinDocument;
  /** Values of a tensor of 32-bit floats; empty if the file has no such tensor. */
  readonly floats: (name: string) => Promise<Float32Array>;
}

export interface TwinDocument {
  readonly drag?: number;
  readonly contact?: Readonly<Record<string, unknown>>;
  readonly provenance?: {
    readonly capture_name?: string;
    readonly settings?: unknown;
    readonly build?: string;
    readonly backend?: string;
    readonly refined_from?: string;
  };
}

/** Reads the header of a twin's file by two requests for ranges. */
export async function readTwinFile(api: Api, path: string, signal: AbortSignal): Promise<TwinFile> {
  const range = async (from: number, bytes: number): Promise<ArrayBuffer> => {
    const answer = await api.fetch(path, { headers: { range: `bytes=${from}-${from + bytes - 1}` }, signal });
    const got = await answer.arrayBuffer();
    return answer.status === 206 ? got : got.slice(from, from + bytes);
  };
  const length = Number(new DataView(await range(0, 8)).getBigUint64(0, true));
  if (length > MOST_BYTES) throw new Error('The header of the twin is too large.');
  const header = JSON.parse(new TextDecoder().decode(await range(8, length))) as Header;
  const floats = async (name: string): Promise<Float32Array> => {
    const place = header[name];
    if (place === undefined || !('data_offsets' in place) || place.dtype !== 'F32') return new Float32Array();
    const [from, to] = place.data_offsets;
    return to > from ? new Float32Array(await range(8 + length + from, to - from)) : new Float32Array();
  };
  return { document: JSON.parse(header.__metadata__?.['bendtwin.twin'] ?? '{}') as TwinDocument, floats };
}

type Header = { readonly __metadata__?: Record<string, string> } & {
  readonly [name: string]: { readonly dtype: string; readonly data_offsets: readonly [number, number] } | undefined;
};

/** Median of values, and what nine of ten lie between; null of none. */
export function spreadOf(values: Float32Array): { low: number; median: number; high: number } | null {
  if (values.length === 0) return null;
  const sorted = values.slice().sort();
  const at = (share: number): number => sorted[Math.round(share * (sorted.length - 1))] ?? 0;
  return { low: at(0.05), median: at(0.5), high: at(0.95) };
}
