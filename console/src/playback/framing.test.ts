import { PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { framing } from './framing';

/** Corners of a box, in an order as of points. */
function box(low: number[], high: number[]): number[] {
  return Array.from({ length: 8 }, (_, corner) => [0, 1, 2].map((axis) => ((corner >> axis) & 1 ? high : low)[axis]!)).flat();
}

/** Largest coordinates in the picture, 1 at its edges. */
function extents(points: number[], aspect: number, from = points): { x: number[]; y: number[] } {
  const { position, target } = framing(Float32Array.from(from), { degrees: 45, aspect })!;
  const camera = new PerspectiveCamera(45, aspect, 0.001, 100);
  camera.up.set(0, 0, 1);
  camera.position.set(...position);
  camera.lookAt(...target);
  camera.updateMatrixWorld();
  const seen = Array.from({ length: points.length / 3 }, (_, i) => new Vector3().fromArray(points, 3 * i).project(camera));
  const ends = (values: number[]): number[] => [Math.min(...values), Math.max(...values)];
  return { x: ends(seen.map(({ x }) => x)), y: ends(seen.map(({ y }) => y)) };
}

describe('the framing of points', () => {
  const flat = box([1, 2, 0], [1.6, 2.1, 0.1]);

  it('fills the picture, with the points in the middle', () => {
    for (const aspect of [0.5, 1, 2.5]) {
      const { x, y } = extents(flat, aspect);
      expect(Math.max(x[1]!, y[1]!), String(aspect)).toBeCloseTo(0.9, 3);
      expect(x[0]! + x[1]!).toBeCloseTo(0, aspect < 2 ? 3 : 1);
      expect(Math.min(x[0]!, y[0]!)).toBeGreaterThan(-0.901);
    }
  });

  it('leaves out points that are not known', () => {
    const { x } = extents(flat, 1, [...flat, NaN, 0, 0]);
    expect(x[1]).toBeCloseTo(0.9, 3);
  });

  it('keeps away from a single point', () => {
    const { position, target } = framing(new Float32Array(3), { degrees: 45, aspect: 1 })!;
    expect(Math.hypot(...position.map((x, i) => x - target[i]!))).toBeCloseTo(0.05, 6);
    expect(framing(new Float32Array([NaN, 0, 0]), { degrees: 45, aspect: 1 })).toBeNull();
  });
});
