import { bytes, floats, indices, Problem, type TwinSurface } from '@bendtwin/client';
import { type Api } from '../../api/client';
import { readSkin, pointCount, type Skin } from '../skin';
import { ofLength, within } from '../tensor';
import type { Tube } from './tubes';

/** The surface that people see of a twin: V vertices that nodes carry, F triangles, and tubes along nodes. */
export interface Surface {
  readonly carriers: Skin;
  /** Corners, counter-clockwise seen from outside, shape [F, 3]. */
  readonly triangles: Uint32Array;
  /** Red, green, blue of each vertex as in images (sRGB), shape [V, 3]; empty if they are not known. */
  readonly colours: Uint8Array;
  /** Tubes, in a twin of a cable. */
  readonly tubes: readonly Tube[];
}

/** Asks for the surface of a twin; null if it is too small for one. */
export async function askSurface(api: Api, twin: string, signal: AbortSignal): Promise<TwinSurface | null> {
  try {
    return await api.get('/v1/twins/{id}/surface', { id: twin, query: { tensors: 'base64' }, signal });
  } catch (error) {
    if (error instanceof Problem && error.status === 404) return null;
    throw error;
  }
}

/** Reads a reply for a twin of N nodes; null if it has no parts. Throws if its arrays do not belong together. */
export function readSurface(reply: Partial<TwinSurface>, nodes: number): Surface | null {
  const carriers = readSkin(reply.carriers ?? {}, nodes, 'carriers');
  const vertices = pointCount(carriers);
  const triangles = indices(reply.triangles, 'triangles');
  if (triangles.length % 3 !== 0) throw new Error('triangles has a corner too many');
  within(triangles, vertices, 'triangles');
  const colours = bytes(reply.colors, 'colors');
  if (colours.length > 0) ofLength(colours, 3 * vertices, 'colors');
  const tubes = readTubes(reply, nodes);
  return triangles.length === 0 && tubes.length === 0 ? null : { carriers, triangles, colours, tubes };
}

function readTubes(reply: Partial<TwinSurface>, nodes: number): Tube[] {
  const starts = indices(reply.tube_starts, 'tube_starts');
  const along = indices(reply.tube_nodes, 'tube_nodes');
  const radii = ofLength(floats(reply.tube_radii, 'tube_radii'), Math.max(starts.length - 1, 0), 'tube_radii');
  within(along, nodes, 'tube_nodes');
  return Array.from(radii, (radius, tube) => {
    const [start, end] = [starts[tube]!, starts[tube + 1]!];
    if (!(end - start >= 2 && end <= along.length)) throw new Error('tube_starts names what is not there');
    if (!(radius > 0)) throw new Error('tube_radii has a radius that is not positive');
    return { nodes: along.subarray(start, end), radius };
  });
}
