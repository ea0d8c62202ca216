import type { CameraHead } from '../file/head';

/** Nearest depth that is seen [m]. */
const NEAREST_M = 1e-6;

/** A calibrated camera: OpenCV's axes and pixels, as docs/formats/capture.md has them. */
export class Projection {
  /** `poses` are camera to world, float32 [1 or K, 3, 4]. */
  constructor(
    private readonly camera: CameraHead,
    private readonly poses: Float32Array,
  ) {}

  /**
   * Pixels of the recorded image at which points [m], shape [M, 3], appear in image k, as column and row,
   * shape [M, 2]; the centre of the first pixel is (0, 0). Not a number for points that are behind the
   * camera or not known.
   */
  pixels(points: Float32Array, image: number): Float32Array {
    const { fx, fy, cx, cy } = this.camera.intrinsics;
    const distort = distortion(this.camera.distortion);
    const pose = this.poses.subarray(...(this.poses.length > 12 ? [12 * image, 12 * image + 12] : [0, 12]));
    const pixels = new Float32Array((2 * points.length) / 3).fill(NaN);
    const at = (i: number): number => pose[i]!;
    for (let m = 0; 3 * m < points.length; m += 1) {
      const dx = points[3 * m]! - at(3);
      const dy = points[3 * m + 1]! - at(7);
      const dz = points[3 * m + 2]! - at(11);
      // The rotation's transpose leads from the world to the camera.
      const z = at(2) * dx + at(6) * dy + at(10) * dz;
      if (!(z > NEAREST_M)) continue;
      const x = (at(0) * dx + at(4) * dy + at(8) * dz) / z;
      const y = (at(1) * dx + at(5) * dy + at(9) * dz) / z;
      const [u, v] = distort(x, y);
      pixels[2 * m] = fx * u + cx;
      pixels[2 * m + 1] = fy * v + cy;
    }
    return pixels;
  }
}

/** Place on the normalised image plane at which a ray through (x, y) at depth 1 appears. */
function distortion({ model, coefficients }: CameraHead['distortion']): (x: number, y: number) => [number, number] {
  const k = (i: number): number => coefficients[i] ?? 0;
  if (model === 'brown_conrady') {
    return (x, y) => {
      const r2 = x * x + y * y;
      const above = 1 + r2 * (k(0) + r2 * (k(1) + r2 * k(4)));
      const radial = above / (1 + r2 * (k(5) + r2 * (k(6) + r2 * k(7))));
      return [
        x * radial + 2 * k(2) * x * y + k(3) * (r2 + 2 * x * x),
        y * radial + k(2) * (r2 + 2 * y * y) + 2 * k(3) * x * y,
      ];
    };
  }
  if (model === 'kannala_brandt') {
    return (x, y) => {
      const r = Math.hypot(x, y);
      if (r < 1e-9) return [x, y];
      const angle = Math.atan(r);
      const a2 = angle * angle;
      const bent = angle * (1 + a2 * (k(0) + a2 * (k(1) + a2 * (k(2) + a2 * k(3)))));
      return [(x * bent) / r, (y * bent) / r];
    };
  }
  return (x, y) => [x, y];
}
