import { floats, indices, type PackedTensor } from '@bendtwin/client';

/** Fields of a recording that a table of it needs: docs/formats/play.md, Recordings. */
export interface RecordingDocument {
  readonly fps: number;
  readonly segments: readonly {
    /** Poses of grippers at frame boundaries, shape [1, K, G, 7]. */
    readonly poses: { readonly poses: PackedTensor };
    readonly grasps?: readonly { readonly gripper?: number; readonly closed?: PackedTensor }[];
  }[];
}

const COLUMNS = 'segment,frame,time_s,gripper,x_m,y_m,z_m,qx,qy,qz,qw,holds';

/** The poses of a recording as CSV: a row for each gripper at each frame boundary. */
export function csvOf({ fps, segments }: RecordingDocument): string {
  const rows = [COLUMNS];
  let frames = 0;
  segments.forEach((segment, index) => {
    const { poses } = segment.poses;
    const [, knots = 0, grippers = 0] = poses.shape;
    const values = floats(poses, 'poses');
    const grasps = (segment.grasps ?? []).map(({ gripper = 0, closed }) => ({
      gripper,
      closed: closed === undefined ? null : indices(closed, 'closed'),
    }));
    for (let knot = 0; knot < knots; knot += 1) {
      for (let g = 0; g < grippers; g += 1) {
        const at = 7 * (knot * grippers + g);
        const own = grasps.filter(({ gripper }) => gripper === g);
        const holds = own.some(({ closed }) => closed === null || closed[knot] === 1);
        const time = ((frames + knot) / fps).toFixed(4);
        const pose = Array.from(values.subarray(at, at + 7), (x) => String(Number(x.toPrecision(7))));
        rows.push([index, knot, time, g, ...pose, holds ? 1 : 0].join(','));
      }
    }
    frames += Math.max(knots - 1, 0);
  });
  return `${rows.join('\n')}\n`;
}
