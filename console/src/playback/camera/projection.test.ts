import { describe, expect, it } from 'vitest';
import { Projection } from './projection';
import { camera } from '../testing';

const HERE = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
/** Turned by 90 degrees about y: its z looks along x of the world; it stands at (1, 2, 3). */
const TURNED = [0, 0, 1, 1, 0, 1, 0, 2, -1, 0, 0, 3];

function pixels(poses: number[], points: number[], image = 0, changes = {}): number[] {
  const projection = new Projection(camera(changes), Float32Array.from(poses));
  return Array.from(projection.pixels(Float32Array.from(points), image), (x) => Number(x.toFixed(3)));
}

describe('a projection', () => {
  it('follows the pinhole', () => {
    expect(pixels(HERE, [0, 0, 2, 0.2, -0.1, 2])).toEqual([50, 40, 60, 35.5]);
  });

  it('leaves out points behind the camera and unknown ones', () => {
    expect(pixels(HERE, [0, 0, -1, NaN, NaN, NaN, 0, 0, 0])).toEqual([NaN, NaN, NaN, NaN, NaN, NaN]);
  });

  it('takes the pose of the image of a camera that moves', () => {
    // 2 m in front of the turned camera, and 0.2 m along its x, which is the world's -z.
    expect(pixels(TURNED, [3, 2, 2.8])).toEqual([60, 40]);
    expect(pixels([...HERE, ...TURNED], [3, 2, 2.8], 1)).toEqual([60, 40]);
    expect(pixels([...HERE, ...TURNED], [0, 0, 1], 0)).toEqual([50, 40]);
  });

  it('distorts as OpenCV does', () => {
    const brown = { model: 'brown_conrady', coefficients: [0.1, 0.01, 0.002, -0.003, 0.001, 0, 0, 0] };
    // r2 = 0.05: radial 1.00502512..., plus the tangential part.
    const r2 = 0.05;
    const radial = 1 + r2 * (0.1 + r2 * (0.01 + r2 * 0.001));
    const u = 0.2 * radial + 2 * 0.002 * 0.2 * 0.1 - 0.003 * (r2 + 2 * 0.04);
    const v = 0.1 * radial + 0.002 * (r2 + 2 * 0.01) + 2 * -0.003 * 0.2 * 0.1;
    const seen = pixels(HERE, [0.2, 0.1, 1], 0, { distortion: brown });
    expect(seen).toEqual([100 * u + 50, 90 * v + 40].map((x) => Number(x.toFixed(3))));
    const fisheye = { model: 'kannala_brandt', coefficients: [0.1, 0, 0, 0] };
    const angle = Math.atan(1);
    const bent = angle * (1 + 0.1 * angle * angle);
    expect(pixels(HERE, [1, 0, 1], 0, { distortion: fisheye })[0]).toBeCloseTo(100 * bent + 50, 2);
    expect(pixels(HERE, [0, 0, 1], 0, { distortion: fisheye })).toEqual([50, 40]);
  });
});
