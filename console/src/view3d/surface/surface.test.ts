import { base64, type TwinSurface } from '@bendtwin/client';
import { describe, expect, it } from 'vitest';
import { NO_FRAME } from '../skin';
import { SurfaceMesh } from './mesh';
import { readSurface } from './surface';

type Numbers = Uint32Array | Float32Array | Uint8Array;

function tensor(values: Numbers, shape = [values.length]): NonNullable<TwinSurface['triangles']> {
  const dtype = values instanceof Uint8Array ? 'UINT8' : values instanceof Uint32Array ? 'UINT32' : 'FLOAT32';
  return { dtype, shape, data: base64(new Uint8Array(values.buffer)) };
}

/** A tetrahedron whose corners are nodes, the last one in the middle between two. */
const TETRAHEDRON: Partial<TwinSurface> = {
  carriers: {
    weight_counts: tensor(Uint32Array.of(1, 1, 1, 2)),
    weight_nodes: tensor(Uint32Array.of(0, 1, 2, 3, 4)),
    weights: tensor(Float32Array.of(1, 1, 1, 0.5, 0.5)),
    frames: tensor(new Uint32Array(12).fill(NO_FRAME), [4, 3]),
    offsets: tensor(new Float32Array(12), [4, 3]),
  },
  triangles: tensor(Uint32Array.of(0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3), [4, 3]),
  colors: tensor(Uint8Array.of(255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9), [4, 3]),
};
const NODES = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0, 0, 1.5]);

describe('readSurface', () => {
  it('reads a reply', () => {
    const surface = readSurface(TETRAHEDRON, 5)!;
    expect([surface.triangles.length, surface.colours[1], surface.tubes.length]).toEqual([12, 0, 0]);
    const tubes = {
      tube_starts: tensor(Uint32Array.of(0, 2, 5)),
      tube_nodes: tensor(Uint32Array.of(0, 1, 2, 3, 4)),
      tube_radii: tensor(Float32Array.of(0.5, 0.25)),
    };
    expect(readSurface(tubes, 5)!.tubes.map(({ nodes, radius }) => [[...nodes], radius])).toEqual([[[0, 1], 0.5], [[2, 3, 4], 0.25]]);
  });

  it('finds nothing in an empty one', () => {
    expect(readSurface({}, 5)).toBeNull();
  });

  it('refuses arrays that do not belong together', () => {
    const wrong: [Partial<TwinSurface>, string][] = [
      [{ ...TETRAHEDRON, triangles: tensor(Uint32Array.of(0, 1, 4)) }, 'triangles'],
      [{ ...TETRAHEDRON, triangles: tensor(Uint32Array.of(0, 1)) }, 'triangles'],
      [{ ...TETRAHEDRON, colors: tensor(new Uint8Array(9)) }, 'colors has 9'],
      [{ tube_starts: tensor(Uint32Array.of(0, 2)), tube_radii: tensor(Float32Array.of(1)) }, 'tube_starts'],
      [{ tube_starts: tensor(Uint32Array.of(0, 2)), tube_nodes: tensor(Uint32Array.of(0, 1)) }, 'tube_radii has 0'],
    ];
    for (const [reply, why] of wrong) expect(() => readSurface(reply, 5)).toThrow(why);
    expect(() => readSurface(TETRAHEDRON, 4)).toThrow('carriers.weight_nodes');
  });
});

describe('the mesh of a surface', () => {
  it('has normals that point away from its middle, also after it has moved', () => {
    const mesh = new SurfaceMesh(readSurface(TETRAHEDRON, 5)!);
    for (const shift of [0, 3]) {
      mesh.place(NODES.map((x) => x + shift));
      for (let v = 0; v < 4; v += 1) {
        const outwards = [0, 1, 2].reduce((sum, a) => {
          return sum + mesh.normals[3 * v + a]! * (mesh.positions[3 * v + a]! - 0.25 - shift);
        }, 0);
        expect(outwards).toBeGreaterThan(0);
      }
    }
    // Of the corner at the origin: the sum of three faces, twice their areas.
    expect(Array.from(mesh.normals.subarray(0, 3))).toEqual([-1, -1, -1]);
  });

  it('gives vertices what their nodes have', () => {
    const mesh = new SurfaceMesh(readSurface(TETRAHEDRON, 5)!);
    const out = new Float32Array(4);
    mesh.spread(Float32Array.of(1, 0, 0, 0.5, 1), out);
    expect([...out]).toEqual([1, 0, 0, 0.75]);
  });
});
