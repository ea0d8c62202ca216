import { describe, expect, it } from 'vitest';
import { Footprint, SIDE } from './footprint';

/** A square of two triangles with this side, at a height. */
function square(side: number, height: number, x = 0): { positions: Float32Array; faces: Uint32Array; radius: number } {
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].flatMap(([u, v]) => [x + side * u!, side * v!, height]);
  return { positions: new Float32Array(corners), faces: Uint32Array.of(0, 1, 2, 0, 2, 3), radius: 0 };
}

/** Area of a shadow, each cell weighted by its darkness [m²]. */
function area({ cells, cell }: Footprint): number {
  return (cells.reduce((sum, shade) => sum + shade, 0) / 255) * cell * cell;
}

/** Shade at a place of the plane z = 0. */
function shadeAt(footprint: Footprint, x: number, y: number): number {
  const [u, v] = [x, y].map((at, axis) => Math.floor(at / footprint.cell) - footprint.corner[axis as 0 | 1]);
  return footprint.cells[SIDE * v! + u!]!;
}

describe('a shadow', () => {
  const ground = { normal: [0, 0, 1], offset_m: 0 } as const;

  it('covers what is below a triangle, softly, and nothing else', () => {
    const footprint = new Footprint(ground, 0.3);
    footprint.cast(square(0.2, 0));
    expect(area(footprint) / 0.04).toBeCloseTo(1, 1);
    expect(shadeAt(footprint, 0.1, 0.1)).toBe(255);
    const edge = shadeAt(footprint, 0.2, 0.1);
    expect(edge).toBeGreaterThan(40);
    expect(edge).toBeLessThan(215);
    const [columns, rows] = footprint.used;
    for (let i = 0; i < SIDE; i += 1) {
      expect(footprint.cells[i]! + footprint.cells[SIDE * i]!).toBe(0);
      expect(footprint.cells[SIDE * (rows - 1) + i]! + footprint.cells[SIDE * i + columns - 1]!).toBe(0);
    }
  });

  it('fades with height, and is not cast from below the ground', () => {
    const footprint = new Footprint(ground, 0.3);
    footprint.cast(square(0.2, 0.12));
    expect(shadeAt(footprint, 0.1, 0.1)).toBeCloseTo(255 / 2, -1);
    footprint.cast(square(0.2, -0.05));
    expect(area(footprint)).toBe(0);
  });

  it('stays where it is when the object moves by whole cells, and holds one that is stretched', () => {
    const footprint = new Footprint(ground, 0.3);
    footprint.cast(square(0.2, 0));
    const [before, corner] = [footprint.cells.slice(), footprint.corner[0]];
    footprint.cast(square(0.2, 0, 5 * footprint.cell));
    expect(footprint.corner[0]).toBe(corner + 5);
    expect(footprint.cells).toEqual(before);
    footprint.cast(square(1.5, 0));
    expect(area(footprint) / 2.25).toBeCloseTo(1, 1);
  });

  it('of points is made of discs', () => {
    const footprint = new Footprint(ground, 0.3);
    footprint.cast({ positions: new Float32Array([0.1, 0.1, 0]), faces: new Uint32Array(0), radius: 0.05 });
    expect(area(footprint) / (Math.PI * 0.0025)).toBeCloseTo(1, 0);
  });

  it('lies in an inclined plane', () => {
    const footprint = new Footprint({ normal: [0.6, 0, 0.8], offset_m: 0.1 }, 0.3);
    footprint.cast({ positions: new Float32Array([0, 0, 0.2]), faces: new Uint32Array(0), radius: 0.02 });
    const [columns, rows] = footprint.used;
    const [x, y, z] = footprint.point(columns / 2, rows / 2);
    expect(0.6 * x + 0.8 * z).toBeCloseTo(0.101, 6);
    // The foot of the point: 0.06 m above the plane.
    expect(Math.hypot(x + 0.036, y, z - 0.152)).toBeLessThan(2 * footprint.cell);
  });
});
