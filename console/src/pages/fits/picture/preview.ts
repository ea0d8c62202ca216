import { floats, indices, type FitPreview } from '@bendtwin/client';
import { millimetres } from '../../../ui/format';
import { errorWords } from '../../parts/error';

/** What a fit has so far: P predicted points in F frames of a sequence. */
export interface Preview {
  /** Index of the sequence in the capture. */
  readonly sequence: number;
  /** Numbers of the frames, ascending, shape [F]. */
  readonly frames: Uint32Array;
  /** Points in these frames [m], shape [F, P, 3]. */
  readonly positions: Float32Array;
}

/** Reads a preview; throws if its arrays do not belong together. */
export function readPreview(reply: FitPreview): Preview {
  const frames = indices(reply.frames, 'frames');
  const positions = floats(reply.positions, 'positions');
  if (frames.length === 0 || positions.length === 0 || positions.length % (3 * frames.length) !== 0) {
    throw new Error('the preview has positions of other frames');
  }
  return { sequence: reply.sequence, frames, positions };
}

/** Points of the frame with this index, shape [P, 3]. */
export function pointsOf({ frames, positions }: Preview, index: number): Float32Array {
  const width = positions.length / frames.length;
  return positions.subarray(index * width, (index + 1) * width);
}

/** The errors of a preview in a sentence or two; `hasEnded` is true of a fit that ended without a twin. */
export function previewWords({ error_m, baseline_m, held_back_m, measure }: FitPreview, hasEnded = false): string {
  const [when, frames] = hasEnded ? ['When it ended', 'it was being fitted to'] : ['Now', 'it is being fitted to'];
  const error = `${when} ${errorWords(error_m, measure)} on the frames that ${frames}`;
  const now = `${error}, standing still ${millimetres(baseline_m)}.`;
  return held_back_m === undefined ? now : `${now} On frames held back: ${millimetres(held_back_m)}.`;
}
