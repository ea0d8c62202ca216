import { floats, type Evaluation, type PredictedMotion } from '@bendtwin/client';
import type { Api } from '../api/client';
import type { Quality, Score } from '../pages/twins/quality';

/** Errors of a frame [m]; null where they were not measured. */
export interface FrameErrors {
  readonly track: number | null;
  readonly chamfer: number | null;
}

/** The predicted motion of a sequence, and its errors. */
export class Prediction {
  /** Number of nodes N. */
  readonly nodeCount: number;
  readonly startFrame: number;
  /** Frames before this one were for fitting. */
  readonly trainFrameCount: number;
  readonly #every: number;
  /** Nodes of the frames that were sent [m], shape [R, N, 3]. */
  readonly positions: Float32Array;
  readonly #track: Float32Array;
  readonly #chamfer: Float32Array;

  constructor(
    reply: PredictedMotion,
    /** Warnings about the prediction. */
    readonly warnings: readonly string[] = [],
    /** Mean errors of this prediction, the first one, and of others beside it. */
    readonly scores: readonly Score[] = [],
  ) {
    this.startFrame = reply.start_frame;
    this.trainFrameCount = reply.train_frame_count;
    this.#every = Math.max(reply.every_frames, 1);
    this.positions = floats(reply.positions, 'positions');
    this.nodeCount = Array.isArray(reply.positions) ? 0 : (reply.positions?.shape[1] ?? 0);
    if (this.nodeCount === 0) throw new Error('the prediction has no nodes');
    this.#track = floats(reply.track_m, 'track_m');
    this.#chamfer = floats(reply.chamfer_l1_m, 'chamfer_l1_m');
  }

  /** Evaluates a twin on a sequence of a capture. */
  static async load(
    api: Api,
    ids: { readonly twin: string; readonly capture: string; readonly sequence: number },
    signal: AbortSignal,
  ): Promise<Prediction> {
    const body = { capture: `captures/${ids.capture}`, motion: { sequence: ids.sequence } };
    const path = `/v1/twins/${encodeURIComponent(ids.twin)}/evaluations?tensors=base64`;
    const { motion, quality } = await api.send<Evaluation>('POST', path, body, signal);
    const { warnings = [], scores = [] } = quality as Quality;
    if (motion === undefined) throw new Error(warnings[0] ?? 'the twin has no prediction of this sequence');
    return new Prediction(motion, warnings, scores);
  }

  /** Nodes in a frame [m], shape [N, 3], or in the last one before it that was sent; null before the start. */
  nodes(frame: number): Float32Array | null {
    if (frame < this.startFrame) return null;
    const width = 3 * this.nodeCount;
    const row = Math.floor((frame - this.startFrame) / this.#every);
    const last = this.positions.length / width - 1;
    const first = Math.min(row, last) * width;
    return this.positions.subarray(first, first + width);
  }

  /** Nodes of all frames that were sent [m], shape [N, 3] each. */
  get all(): Float32Array[] {
    const width = 3 * this.nodeCount;
    return Array.from({ length: this.positions.length / width }, (_, row) => {
      return this.positions.subarray(row * width, (row + 1) * width);
    });
  }

  errors(frame: number): FrameErrors {
    const of = (values: Float32Array): number | null => {
      const value = values[frame - this.startFrame];
      return value === undefined || Number.isNaN(value) ? null : value;
    };
    return { track: of(this.#track), chamfer: of(this.#chamfer) };
  }
}
