import { openTwinFile } from '@bendtwin/client';
import type { Api } from '../../api/client';

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

/** Opens the file of a twin by its id. */
export async function readTwinFile(api: Api, twin: string, signal: AbortSignal): Promise<TwinFile> {
  const { document, tensors, read } = await openTwinFile(api, twin, signal);
  const floats = async (name: string): Promise<Float32Array> => {
    const tensor = tensors.get(name);
    return tensor?.dtype === 'F32' ? new Float32Array((await read(...tensor.data_offsets)).buffer) : new Float32Array();
  };
  return { document: document as TwinDocument, floats };
}

/** Median of values, and what nine of ten lie between; null of none. */
export function spreadOf(values: Float32Array): { low: number; median: number; high: number } | null {
  if (values.length === 0) return null;
  const sorted = values.slice().sort();
  const at = (share: number): number => sorted[Math.round(share * (sorted.length - 1))] ?? 0;
  return { low: at(0.05), median: at(0.5), high: at(0.95) };
}
