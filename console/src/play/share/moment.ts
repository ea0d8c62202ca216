import { base64, bytesOfBase64, packed, type World } from '@bendtwin/client';
import type { Factors } from '../protocol/messages';

/** A moment of a play that another play can begin with. */
export interface Moment {
  /** Nodes [m], shape [N, 3]. */
  readonly positions: Float32Array;
  /** Control points [m], shape [C, 3]. */
  readonly controls: Float32Array;
  /** Hands that hold the object no more. */
  readonly dropped: readonly number[];
  readonly world: World;
  readonly vary: Factors;
}

/** Most nodes and control points of a moment that an address has. */
export const MOST_POINTS = 1500;

/** The fields of a first message that begins with a moment. */
export function beginOf(moment: Partial<Moment>): object {
  const { positions, controls, dropped, world, vary } = moment;
  const given = positions === undefined || controls === undefined ? {} : {
    initial: {
      given: {
        positions: packed(positions, [positions.length / 3, 3]),
        ...(controls.length === 0 ? {} : { controls: packed(controls, [controls.length / 3, 3]) }),
      },
    },
  };
  return { ...given, world: world ?? {}, vary: vary ?? {}, dropped: dropped ?? [] };
}

/** A moment as an address has it; without its points if they are too many. */
export function writeMoment(moment: Moment): URLSearchParams {
  const query = new URLSearchParams();
  const points = [moment.positions, moment.controls];
  if (points[0]!.length + points[1]!.length <= 3 * MOST_POINTS) query.set('points', points.map(coded).join('~'));
  if (moment.dropped.length > 0) query.set('dropped', moment.dropped.join(','));
  if (Object.keys(moment.world).length > 0) query.set('world', JSON.stringify(moment.world));
  if (Object.keys(moment.vary).length > 0) query.set('vary', JSON.stringify(moment.vary));
  return query;
}

/** The moment in an address, for a twin with these numbers of nodes and control points; damaged parts are left out. */
export function readMoment(query: URLSearchParams, nodes: number, controls: number): Partial<Moment> {
  const [first, second] = (query.get('points') ?? '').split('~');
  const points = [decoded(first, nodes), decoded(second, controls)] as const;
  const dropped = (query.get('dropped') ?? '').split(',').filter((text) => /^\d{1,2}$/.test(text)).map(Number);
  const [world, vary] = [parsed(query.get('world')), parsed(query.get('vary'))];
  return {
    ...(points[0] !== null && points[1] !== null ? { positions: points[0], controls: points[1] } : {}),
    dropped,
    ...(world === null ? {} : { world: world as World }),
    ...(vary === null ? {} : { vary: vary as Factors }),
  };
}

/** Points as integers of 0.1 mm, little-endian, in base64 for addresses. */
function coded(points: Float32Array): string {
  const numbers = new DataView(new ArrayBuffer(2 * points.length));
  points.forEach((x, i) => numbers.setInt16(2 * i, Math.min(Math.max(Math.round(x * 1e4), -32767), 32767), true));
  return base64(new Uint8Array(numbers.buffer)).replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, '');
}

function decoded(text: string | undefined, count: number): Float32Array | null {
  try {
    const bytes = bytesOfBase64((text ?? '').replaceAll('-', '+').replaceAll('_', '/'));
    if (bytes.length !== 6 * count) return null;
    const view = new DataView(bytes.buffer);
    return Float32Array.from({ length: 3 * count }, (_, i) => view.getInt16(2 * i, true) / 1e4);
  } catch {
    return null;
  }
}

function parsed(text: string | null): object | null {
  try {
    const value: unknown = JSON.parse(text ?? 'null');
    return typeof value === 'object' && !Array.isArray(value) ? value : null;
  } catch {
    return null;
  }
}
