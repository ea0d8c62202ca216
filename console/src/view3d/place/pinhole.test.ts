import { PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { Projection } from '../../playback/camera/projection';
import { camera } from '../../playback/testing';
import { fitted, projectionOf, standOf } from './pinhole';

/** Turned by 90 degrees about y: its z looks along x of the world; it stands at (1, 2, 3). */
const TURNED = [0, 0, 1, 1, 0, 1, 0, 2, -1, 0, 0, 3];

describe('the view of a calibrated camera', () => {
  it('shows points where the image has them, for every shape of the canvas', () => {
    const head = camera({});
    const points = [3, 2, 2.8, 4, 2.5, 3.1, 2, 1.7, 2.9];
    const pixels = new Projection(head, Float32Array.from(TURNED)).pixels(Float32Array.from(points), 0);
    for (const [width, height] of [[500, 200], [200, 700], [320, 240]] as const) {
      const pinhole = { ...head, pose: TURNED };
      const view = new PerspectiveCamera();
      const { position, turn } = standOf(pinhole);
      view.position.copy(position);
      view.quaternion.copy(turn);
      view.updateMatrixWorld();
      view.projectionMatrix.copy(projectionOf(pinhole, width, height, { near: 0.01, far: 100 }));
      const { scale, left, top } = fitted(head.size, width, height);
      for (let m = 0; m < 3; m += 1) {
        const seen = new Vector3().fromArray(points, 3 * m).project(view);
        expect(((seen.x + 1) / 2) * width).toBeCloseTo(scale * (pixels[2 * m]! + 0.5) + left, 3);
        expect(((1 - seen.y) / 2) * height).toBeCloseTo(scale * (pixels[2 * m + 1]! + 0.5) + top, 3);
        expect(Math.abs(seen.z)).toBeLessThan(1);
      }
    }
  });

  it('has all of the image in the canvas, in its middle', () => {
    expect(fitted([100, 50], 400, 400)).toEqual({ scale: 4, left: 0, top: 100 });
    expect(fitted([100, 50], 400, 100)).toEqual({ scale: 2, left: 100, top: 0 });
  });
});
