import { Matrix4, Quaternion, Vector3 } from 'three';

/** A calibrated camera in one moment, in OpenCV's axes and pixels: docs/formats/capture.md. */
export interface Pinhole {
  /** Columns and rows of the recorded images, which the intrinsics are for. */
  readonly size: readonly [number, number];
  readonly intrinsics: { readonly fx: number; readonly fy: number; readonly cx: number; readonly cy: number };
  /** Camera to world, shape [3, 4]. */
  readonly pose: ArrayLike<number>;
}

/** Place of an image in a canvas that shows all of it: canvas pixels for one of the image, and the free margins. */
export interface Fit {
  readonly scale: number;
  readonly left: number;
  readonly top: number;
}

/** Fits an image into a canvas of this size. */
export function fitted([columns, rows]: readonly [number, number], width: number, height: number): Fit {
  const scale = Math.min(width / columns, height / rows);
  return { scale, left: (width - scale * columns) / 2, top: (height - scale * rows) / 2 };
}

/** Projection of WebGL with which points are drawn where they are in the image, fitted into a canvas of this size. */
export function projectionOf(
  { size, intrinsics: { fx, fy, cx, cy } }: Pinhole,
  width: number,
  height: number,
  { near, far }: { readonly near: number; readonly far: number },
): Matrix4 {
  const { scale, left, top } = fitted(size, width, height);
  // The centre of the first pixel is half a pixel from the edge. Cameras of WebGL look along -z, with y upwards.
  const x = (2 * (scale * (cx + 0.5) + left)) / width - 1;
  const y = 1 - (2 * (scale * (cy + 0.5) + top)) / height;
  return new Matrix4().set(
    (2 * scale * fx) / width, 0, -x, 0,
    0, (2 * scale * fy) / height, -y, 0,
    0, 0, -(far + near) / (far - near), (-2 * far * near) / (far - near),
    0, 0, -1, 0,
  );
}

/** Place and turn of WebGL's camera that stands where a calibrated one does. */
export function standOf({ pose }: Pinhole): { position: Vector3; turn: Quaternion } {
  const at = (i: number): number => pose[i]!;
  const turn = new Matrix4().set(
    at(0), -at(1), -at(2), 0,
    at(4), -at(5), -at(6), 0,
    at(8), -at(9), -at(10), 0,
    0, 0, 0, 1,
  );
  return { position: new Vector3(at(3), at(7), at(11)), turn: new Quaternion().setFromRotationMatrix(turn) };
}
