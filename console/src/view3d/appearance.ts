import { openTwinFile, type Entry } from '@bendtwin/client';
import type { Api } from '../api/client';
import { mayDownload } from '../api/visit';
import { startsOf, type Skin } from './skin';

/** Gaussians that nodes carry, G of them: docs/formats/twin.md. */
export interface Splats {
  readonly carriers: Skin;
  /** Standard deviations [m], shape [G, 3]. */
  readonly scales: Float32Array;
  /** Rotations at rest, x, y, z, w, shape [G, 4]. */
  readonly rotations: Float32Array;
  /** 0 to 1, shape [G]. */
  readonly opacities: Float32Array;
  /** sRGB, 0 to 1, shape [G, 3]. */
  readonly colours: Float32Array;
}

/** The look of a twin. */
export interface Appearance {
  /** Red, green, blue of each skin point, shape [M, 3]; empty if they are not known. */
  readonly skinColours: Uint8Array;
  readonly splats: Splats | null;
}

/** Sizes of numbers [bytes]. */
const WIDTHS: Readonly<Record<string, number>> = { F32: 4, U32: 4, U8: 1 };

/** The look of a twin, read from the parts of its file that have it; null if it has none, or the file may not be read. */
export async function loadAppearance(api: Api, twin: string, signal: AbortSignal): Promise<Appearance | null> {
  if (!mayDownload()) return null;
  const { tensors, read } = await openTwinFile(api, twin, signal);
  const found = [...tensors].filter(([name]) => name === 'skin.color' || name.startsWith('splats.'));
  const offsets = found.flatMap(([, entry]) => entry.data_offsets);
  const [low, high] = [Math.min(...offsets), Math.max(...offsets)];
  return high > low ? readAppearance(new Map(found), await read(low, high), low) : null;
}

/** Reads tensors whose bytes begin at `low` of the file's data; throws if they do not belong together. */
export function readAppearance(
  entries: ReadonlyMap<string, Entry>,
  bytes: Uint8Array<ArrayBuffer>,
  low: number,
): Appearance | null {
  const part = (name: string, dtype: string): ArrayBuffer => {
    const entry = entries.get(name);
    if (entry === undefined) return new ArrayBuffer(0);
    const [start, end] = entry.data_offsets;
    if (entry.dtype !== dtype || (end - start) % WIDTHS[dtype]! !== 0) throw new Error(`${name} is no ${dtype}`);
    // A copy, as the place of a tensor need not be a multiple of its numbers' size.
    return bytes.slice(start - low, end - low).buffer;
  };
  const floats = (name: string): Float32Array => new Float32Array(part(`splats.${name}`, 'F32'));
  const indices = (name: string): Uint32Array => new Uint32Array(part(`splats.${name}`, 'U32'));
  const skinColours = new Uint8Array(part('skin.color', 'U8'));
  const opacities = floats('opacity');
  const count = opacities.length;
  if (count === 0) return skinColours.length === 0 ? null : { skinColours, splats: null };
  const carriers: Skin = {
    starts: startsOf(indices('weight_count')),
    nodes: indices('weight_node'),
    weights: floats('weight'),
    frames: indices('frame'),
    offsets: floats('offset'),
  };
  const splats = { carriers, scales: floats('scale'), rotations: floats('rotation'), opacities, colours: floats('color') };
  const lengths = [
    carriers.starts.length - 1, carriers.frames.length / 3, carriers.offsets.length / 3,
    splats.scales.length / 3, splats.rotations.length / 4, splats.colours.length / 3,
  ];
  const weights = carriers.starts[carriers.starts.length - 1];
  if (lengths.some((length) => length !== count) || carriers.nodes.length !== weights || carriers.weights.length !== weights) {
    throw new Error('the tensors of the splats do not belong together');
  }
  return { skinColours, splats };
}
