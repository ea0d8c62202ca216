import { describe, expect, it } from 'vitest';
import { SurfaceMesh } from './mesh';
import { AROUND, nodeOf, placeTube, vertexCount, type Tube } from './tubes';
import type { Surface } from './surface';

/** A surface that is one tube along nodes. */
function meshOf(tube: Tube, nodes: Float32Array): SurfaceMesh {
  const none = { starts: new Uint32Array(1), nodes: new Uint32Array(0), weights: new Float32Array(0) };
  const carriers = { ...none, frames: new Uint32Array(0), offsets: new Float32Array(0) };
  const surface: Surface = { carriers, triangles: new Uint32Array(0), colours: new Uint8Array(0), tubes: [tube] };
  const mesh = new SurfaceMesh(surface);
  mesh.place(nodes);
  return mesh;
}

/** Enclosed volume [m³], and whether each edge has two faces, one each way. */
function enclosed({ faces, positions: p }: SurfaceMesh): { volume: number; isClosed: boolean } {
  const edges = new Map<string, number>();
  let volume = 0;
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = faces.subarray(f, f + 3) as unknown as [number, number, number];
    for (const [i, j] of [[a, b], [b, c], [c, a]]) edges.set(`${i} ${j}`, (edges.get(`${i} ${j}`) ?? 0) + 1);
    const at = (v: number, k: number): number => p[3 * v + (k % 3)]!;
    for (let k = 0; k < 3; k += 1) {
      volume += (at(a, k) * (at(b, k + 1) * at(c, k + 2) - at(b, k + 2) * at(c, k + 1))) / 6;
    }
  }
  const isClosed = [...edges].every(([edge, n]) => n === 1 && edges.get(edge.split(' ').reverse().join(' ')) === 1);
  return { volume, isClosed };
}

/** Area of the section of a tube, over the square of its radius. */
const SECTION = (AROUND / 2) * Math.sin((2 * Math.PI) / AROUND);

const LINE = new Float32Array([0, 0, 0.1, 0.1, 0, 0.1, 0.2, 0, 0.1, 0.3, 0, 0.1]);

describe('a tube', () => {
  it('begins where one computes by hand', () => {
    const tube = { nodes: Uint32Array.of(0, 1), radius: 0.01 };
    const out = new Float32Array(3 * vertexCount(tube));
    placeTube(tube, LINE, out, 0);
    // Along x; across is z, and the third axis x × z = -y.
    const half = 0.01 * Math.SQRT1_2;
    const expected = [0, 0, 0.11, 0, -half, 0.1 + half, 0, -0.01, 0.1];
    expected.forEach((x, i) => expect(out[i]).toBeCloseTo(x, 6));
    expect([...out.slice(-6)].map((x) => Number(x.toFixed(6)))).toEqual([0, 0, 0.1, 0.1, 0, 0.1]);
  });

  it('is closed, and has its volume', () => {
    const { volume, isClosed } = enclosed(meshOf({ nodes: Uint32Array.of(0, 1, 2, 3), radius: 0.01 }, LINE));
    expect(isClosed).toBe(true);
    expect(volume / (0.3 * 1e-4 * SECTION)).toBeCloseTo(1, 4);
  });

  it('along a ring has no ends', () => {
    const ring = Float32Array.from({ length: 120 }, (_, i) => {
      const angle = (2 * Math.PI * Math.floor(i / 3)) / 40;
      return [0.1 * Math.cos(angle), 0.1 * Math.sin(angle), 0.2][i % 3]!;
    });
    const nodes = Uint32Array.from({ length: 41 }, (_, k) => k % 40);
    const { volume, isClosed } = enclosed(meshOf({ nodes, radius: 0.005 }, ring));
    expect(isClosed).toBe(true);
    expect(Math.abs(volume / (2 * Math.PI * 0.1 * 25e-6 * SECTION) - 1)).toBeLessThan(0.02);
  });

  it('turns as little as possible: along a plane curve one axis stays across the plane', () => {
    // A quarter of a circle in the plane y = 0, with vertices at their radius all along.
    const arc = Float32Array.from({ length: 60 }, (_, i) => {
      const angle = (0.5 * Math.PI * Math.floor(i / 3)) / 19;
      return [Math.sin(angle), 0, 1 - Math.cos(angle)][i % 3]!;
    });
    const { positions } = meshOf({ nodes: Uint32Array.from({ length: 20 }, (_, k) => k), radius: 0.05 }, arc);
    for (let section = 0; section < 20; section += 1) {
      const offset = (spoke: number): number[] =>
        [0, 1, 2].map((a) => positions[3 * (AROUND * section + spoke) + a]! - arc[3 * section + a]!);
      for (let spoke = 0; spoke < AROUND; spoke += 1) expect(Math.hypot(...offset(spoke))).toBeCloseTo(0.05, 5);
      expect(Math.abs(offset(2)[1]!)).toBeCloseTo(0.05, 5);
    }
  });

  it('without a direction is finite', () => {
    for (const nodes of [new Float32Array(9).fill(0.1), new Float32Array([0, 0, 0, 0, 0, 1, 0, 0, 0])]) {
      const { positions } = meshOf({ nodes: Uint32Array.of(0, 1, 2), radius: 0.01 }, nodes);
      expect(positions.every(Number.isFinite)).toBe(true);
    }
  });

  it('knows the node of each vertex', () => {
    const open = { nodes: Uint32Array.of(5, 6, 7), radius: 1 };
    expect([0, 7, 8, 23, 24, 25].map((v) => nodeOf(open, v))).toEqual([5, 5, 6, 7, 5, 7]);
  });
});
