import type { TwinShape } from '../view3d/shape';
import type { Surface } from '../view3d/surface/surface';
import type { Tube } from '../view3d/surface/tubes';
import { ofLength, within } from '../view3d/tensor';
import { pointCount } from '../view3d/skin';
import type { TwinFile } from './file';
import type { Model } from './physics/model';
import { readSkin } from './twin';

/** What is drawn of a twin file, whose model this is. */
export function readShape(file: TwinFile, model: Model): TwinShape {
  const rest = Float32Array.from(model.rest);
  const skinColours = file.bytes('skin.color');
  return {
    rest,
    controls: Float32Array.from(model.controls),
    hands: model.hands,
    springs: new Uint32Array(0),
    restLengths: new Float32Array(0),
    springStiffness: new Float32Array(0),
    triplets: new Uint32Array(0),
    bendStiffness: new Float32Array(0),
    rods: [],
    skin: readSkin(file),
    skinSd: new Float32Array(0),
    surface: readSurface(file, rest.length / 3),
    appearance: skinColours.length === 0 ? null : { skinColours, splats: null },
    ground: model.ground === null ? null : { normal: [...model.ground.normal], offset_m: model.ground.offset },
    gravity: [...model.gravity],
    fps: model.fps,
    massKg: null,
    mass: model.masses.reduce((sum, mass) => sum + mass, 0),
    spacing: spacingOf(rest),
  };
}

/** The surface of a twin of N nodes; null for a twin without one. */
function readSurface(file: TwinFile, nodes: number): Surface | null {
  const carriers = file.carried('surface', nodes);
  const triangles = file.indices('surface.triangle');
  const tubes = readTubes(file, nodes);
  if (triangles.length === 0 && tubes.length === 0) return null;
  if (triangles.length % 3 !== 0) throw new Error('surface.triangle has a corner too many');
  within(triangles, pointCount(carriers), 'surface.triangle');
  const colours = file.bytes('surface.color');
  if (colours.length > 0) ofLength(colours, 3 * pointCount(carriers), 'surface.color');
  return { carriers, triangles, colours, tubes };
}

function readTubes(file: TwinFile, nodes: number): Tube[] {
  const lengths = file.indices('surface.tube_length');
  const radii = ofLength(file.floats('surface.tube_radius'), lengths.length, 'surface.tube_radius');
  const total = lengths.reduce((sum, length) => sum + length, 0);
  const along = ofLength(file.indices('surface.tube_node'), total, 'surface.tube_node');
  within(along, nodes, 'surface.tube_node');
  let start = 0;
  return Array.from(lengths, (length, tube) => {
    if (length < 2) throw new Error('surface.tube_length has a tube of less than two nodes');
    return { nodes: along.subarray(start, (start += length)), radius: radii[tube]! };
  });
}

/** Mean distance from a node to the one nearest to it [m], of at most 300 nodes. */
function spacingOf(rest: Float32Array): number {
  const count = rest.length / 3;
  const step = Math.max(1, Math.ceil(count / 300));
  const nearest: number[] = [];
  for (let a = 0; a < count; a += step) {
    let least = Infinity;
    for (let b = 0; b < count; b += 1) {
      const [x, y, z] = [rest[3 * a]! - rest[3 * b]!, rest[3 * a + 1]! - rest[3 * b + 1]!, rest[3 * a + 2]! - rest[3 * b + 2]!];
      const square = x * x + y * y + z * z;
      if (square > 0 && square < least) least = square;
    }
    if (Number.isFinite(least)) nearest.push(Math.sqrt(least));
  }
  return nearest.length === 0 ? 0.01 : nearest.reduce((sum, length) => sum + length, 0) / nearest.length;
}
