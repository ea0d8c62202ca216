import { floats, indices, type TwinGeometry } from '@bendtwin/client';
import { ofLength, within } from './tensor';

/** Points of a surface that nodes carry, M points and K weights: docs/formats/twin.md, Skin. */
export interface Skin {
  /** Weights before each point, and of all, shape [M + 1]. */
  readonly starts: Uint32Array;
  /** Node of each weight, shape [K]. */
  readonly nodes: Uint32Array;
  /** Weights, of which those of a point sum up to 1, shape [K]. */
  readonly weights: Float32Array;
  /** Nodes a, b, c of the frame of each offset, or `NO_FRAME`, shape [M, 3]. */
  readonly frames: Uint32Array;
  /** Offsets along the axes of the frames [m], shape [M, 3]. */
  readonly offsets: Float32Array;
}

/** Stands for a frame whose axes are those of the world. */
export const NO_FRAME = 0xffffffff;
/** Sine of the angle between a frame's edges up to which its nodes span no triangle. */
const LEAST_SINE = 1e-4;

/** Number of points. */
export function pointCount(skin: Skin): number {
  return skin.starts.length - 1;
}

/** Starts of rows of these lengths in a list, and its length. */
export function startsOf(counts: Uint32Array): Uint32Array {
  const starts = new Uint32Array(counts.length + 1);
  counts.forEach((count, row) => (starts[row + 1] = starts[row]! + count));
  return starts;
}

/** Reads the carriers of points from a reply, for a twin of N nodes; throws if its arrays do not belong together. */
export function readSkin(reply: NonNullable<TwinGeometry['skin']>, nodes: number, name = 'skin'): Skin {
  const starts = startsOf(indices(reply.weight_counts, `${name}.weight_counts`));
  const points = starts.length - 1;
  const carriers = ofLength(indices(reply.weight_nodes, `${name}.weight_nodes`), starts[points]!, `${name}.weight_nodes`);
  within(carriers, nodes, `${name}.weight_nodes`);
  const frames = ofLength(indices(reply.frames, `${name}.frames`), 3 * points, `${name}.frames`);
  within(frames.filter((node) => node !== NO_FRAME), nodes, `${name}.frames`);
  return {
    starts,
    nodes: carriers,
    weights: ofLength(floats(reply.weights, `${name}.weights`), carriers.length, `${name}.weights`),
    frames,
    offsets: ofLength(floats(reply.offsets, `${name}.offsets`), 3 * points, `${name}.offsets`),
  };
}

/** Places the points where nodes [N, 3] are; both in metres, `out` has the shape [M, 3]. */
export function placeSkin(skin: Skin, nodes: Float32Array, out: Float32Array): void {
  const { starts, weights } = skin;
  const count = pointCount(skin);
  for (let m = 0; m < count; m += 1) {
    let x = 0;
    let y = 0;
    let z = 0;
    for (let k = starts[m]!, end = starts[m + 1]!; k < end; k += 1) {
      const weight = weights[k]!;
      const at = 3 * skin.nodes[k]!;
      x += weight * nodes[at]!;
      y += weight * nodes[at + 1]!;
      z += weight * nodes[at + 2]!;
    }
    out[3 * m] = x;
    out[3 * m + 1] = y;
    out[3 * m + 2] = z;
    if (skin.offsets[3 * m] !== 0 || skin.offsets[3 * m + 1] !== 0 || skin.offsets[3 * m + 2] !== 0) {
      addOffset(skin, m, nodes, out);
    }
  }
}

/** Adds o1 e1 + o2 e2 + o3 e3, where e1 is along b - a, e3 along (b - a) x (c - a), and e2 = e3 x e1. */
function addOffset(skin: Skin, m: number, nodes: Float32Array, out: Float32Array): void {
  const [o1, o2, o3] = [skin.offsets[3 * m]!, skin.offsets[3 * m + 1]!, skin.offsets[3 * m + 2]!];
  if (skin.frames[3 * m] === NO_FRAME) {
    out[3 * m]! += o1;
    out[3 * m + 1]! += o2;
    out[3 * m + 2]! += o3;
    return;
  }
  const [a, b, c] = [3 * skin.frames[3 * m]!, 3 * skin.frames[3 * m + 1]!, 3 * skin.frames[3 * m + 2]!];
  let [ux, uy, uz] = [nodes[b]! - nodes[a]!, nodes[b + 1]! - nodes[a + 1]!, nodes[b + 2]! - nodes[a + 2]!];
  const [vx, vy, vz] = [nodes[c]! - nodes[a]!, nodes[c + 1]! - nodes[a + 1]!, nodes[c + 2]! - nodes[a + 2]!];
  let [nx, ny, nz] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
  // Math.hypot takes ten times as long, for thousands of points in every picture.
  const lu = Math.sqrt(ux * ux + uy * uy + uz * uz);
  const lv = Math.sqrt(vx * vx + vy * vy + vz * vz);
  const ln = Math.sqrt(nx * nx + ny * ny + nz * nz);
  if (!(ln > LEAST_SINE * lu * lv) || lu === 0) return;
  [ux, uy, uz] = [ux / lu, uy / lu, uz / lu];
  [nx, ny, nz] = [nx / ln, ny / ln, nz / ln];
  const [wx, wy, wz] = [ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux];
  out[3 * m]! += o1 * ux + o2 * wx + o3 * nx;
  out[3 * m + 1]! += o1 * uy + o2 * wy + o3 * ny;
  out[3 * m + 2]! += o1 * uz + o2 * wz + o3 * nz;
}
