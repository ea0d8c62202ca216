import { floats, indices, type FitPreview } from '@bendtwin/client';
import { millimetres } from '../../../ui/format';

/** What a fit has so far: P predicted points in F frames of a sequence. */
export interface Preview {
  /** Index of the sequence in the capture. */
  readonly sequence: number;
  /** Numbers of the frames, ascending, shape [F]. */
  readonly frames: Uint32Array;
  /** Points in these frames [m], shape [F, P, 3]. */
  readonly positions: Float32Array;
}

/** Words for the kinds of error. */
const MEASURES: Record<string, string> = { track: 'tracks', coordinate: 'coordinates', chamfer: 'Chamfer' };

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

/** A kind of error in a word: tracks, coordinates or Chamfer. */
export function measureWord(measure: string): string {
  return MEASURES[measure] ?? measure;
}

/** An error with its kind, as "8.3 mm (tracks)". */
export function errorWords(metres: number | null | undefined, measure: string | null | undefined): string {
  const kind = measure ? ` (${measureWord(measure)})` : '';
  return `${millimetres(metres)}${kind}`;
}

/** The errors of a preview in a sentence or two; `hasEnded` is true of a fit that ended without a twin. */
export function previewWords({ error_m, baseline_m, held_back_m, measure }: FitPreview, hasEnded = false): string {
  const when = hasEnded ? 'It ended at' : 'Now';
  const now = `${when} ${errorWords(error_m, measure)}, standing still ${millimetres(baseline_m)}.`;
  return held_back_m === undefined ? now : `${now} On frames held back: ${millimetres(held_back_m)}.`;
}
