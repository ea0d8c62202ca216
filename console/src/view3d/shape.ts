import { floats, indices, type TwinGeometry, type World } from '@bendtwin/client';
import type { Api } from '../api/client';
import { loadAppearance, type Appearance } from './appearance';
import { readSkin, type Skin } from './skin';
import { askSurface, readSurface, type Surface } from './surface/surface';
import { ofLength, within } from './tensor';

/** Points with normal . x >= offset are above it. */
export interface Plane {
  readonly normal: readonly [number, number, number];
  readonly offset_m: number;
}

/** Parts of a twin: N nodes, C control points, E springs, T triplets. */
export interface TwinShape {
  /** Nodes at rest [m], shape [N, 3]. */
  readonly rest: Float32Array;
  /** Control points at rest [m], shape [C, 3]. */
  readonly controls: Float32Array;
  /** Hand of each control point, shape [C]. */
  readonly hands: Uint32Array;
  /** Endpoints of springs, from N on control points, shape [E, 2]. */
  readonly springs: Uint32Array;
  /** Lengths of springs at rest [m], shape [E]. */
  readonly restLengths: Float32Array;
  /** Stiffness [N per unit strain], or per unit mass where the mass is unknown, shape [E]; may be empty. */
  readonly springStiffness: Float32Array;
  /** Endpoints of bending triplets, the centre in the middle, shape [T, 3]. */
  readonly triplets: Uint32Array;
  /** Stiffness [N m/rad], or per unit mass, shape [T]; may be empty. */
  readonly bendStiffness: Float32Array;
  /** Standard deviation of each skin point that the recordings leave [m], shape [M]. Empty if it is not known. */
  readonly skinSd: Float32Array;
  readonly rods: readonly Uint32Array[];
  readonly skin: Skin;
  /** The surface that people see; null if the twin has none. */
  readonly surface: Surface | null;
  /** Colours of the skin and splats; null if the twin has none. */
  readonly appearance: Appearance | null;
  readonly ground: Plane | null;
  /** [m/s^2] */
  readonly gravity: readonly [number, number, number];
  readonly fps: number;
  readonly massKg: number | null;
  /** Mass of all nodes [kg], or in units of a node where the mass is not known. */
  readonly mass: number;
  /** Mean length of springs between nodes [m]. */
  readonly spacing: number;
}

/** Asks for the shape of a twin. */
export async function loadShape(api: Api, twin: string, signal: AbortSignal): Promise<TwinShape> {
  const reply = api.get('/v1/twins/{id}/geometry', { id: twin, query: { tensors: 'base64' }, signal });
  const [geometry, appearance, surface] = await Promise.all([
    reply, loadAppearance(api, twin, signal), askSurface(api, twin, signal),
  ]);
  const shape = readShape(geometry);
  return { ...shape, appearance, surface: surface === null ? null : readSurface(surface, shape.rest.length / 3) };
}

/** Reads a reply; throws if its arrays do not belong together. */
export function readShape(reply: Partial<TwinGeometry>): TwinShape {
  const rest = floats(reply.rest_positions, 'rest_positions');
  const controls = floats(reply.controls, 'controls');
  const nodes = rest.length / 3;
  const springs = indices(reply.edges, 'edges');
  const triplets = indices(reply.triplets, 'triplets');
  within(springs, nodes + controls.length / 3, 'edges');
  within(triplets, nodes + controls.length / 3, 'triplets');
  const starts = indices(reply.rod_starts, 'rod_starts');
  const rodNodes = indices(reply.rod_nodes, 'rod_nodes');
  within(rodNodes, nodes, 'rod_nodes');
  const skin = readSkin(reply.skin ?? {}, nodes);
  const skinSd = floats(reply.skin_sd, 'skin_sd');
  return {
    rest,
    controls,
    hands: ofLength(indices(reply.hands, 'hands'), controls.length / 3, 'hands'),
    springs,
    restLengths: ofLength(floats(reply.rest_lengths, 'rest_lengths'), springs.length / 2, 'rest_lengths'),
    springStiffness: floats(reply.spring_stiffness, 'spring_stiffness'),
    triplets,
    bendStiffness: floats(reply.bend_stiffness, 'bend_stiffness'),
    rods: Array.from(starts.subarray(1), (end, rod) => rodNodes.subarray(starts[rod], end)),
    skin,
    skinSd: skinSd.length === 0 ? skinSd : ofLength(skinSd, skin.starts.length - 1, 'skin_sd'),
    surface: null,
    appearance: null,
    ground: reply.ground === undefined ? null : planeOf(reply.ground),
    gravity: vectorOf(reply.gravity, [0, 0, 0]),
    fps: reply.fps ?? 30,
    massKg: reply.mass_kg ?? null,
    mass: floats(reply.masses, 'masses').reduce((sum, mass) => sum + mass, 0),
    spacing: reply.spacing_m || 0.01,
  };
}

/** A plane as the wire has it. */
export function planeOf(plane: Partial<NonNullable<World['ground']>>): Plane {
  return { normal: vectorOf(plane.normal, [0, 0, 1]), offset_m: plane.offset_m ?? 0 };
}

/** Length of the diagonal of the box around points, shape [M, 3], 1 cm at least [m]. */
export function sizeOf(points: Float32Array): number {
  if (points.length === 0) return 0.1;
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  points.forEach((x, i) => {
    low[i % 3] = Math.min(low[i % 3]!, x);
    high[i % 3] = Math.max(high[i % 3]!, x);
  });
  return Math.max(Math.hypot(...high.map((x, axis) => x - low[axis]!)), 0.01);
}

function vectorOf(values: readonly number[] | undefined, absent: [number, number, number]): [number, number, number] {
  const [x, y, z] = values ?? [];
  return x === undefined || y === undefined || z === undefined ? absent : [x, y, z];
}
