import { packed } from '@bendtwin/client';
import { describe, expect, it } from 'vitest';
import { predictorText, type Score } from '../../pages/twins/quality';
import { Prediction } from '../prediction';
import { Errors } from './errors';

/** A prediction of four frames, the first two of them for fitting, with these errors. */
function errors(fields: object, scores: readonly unknown[] = [], trainFrames = 2): Errors {
  const motion = {
    name: '', recording: '', sequence: 0, fps: 30, frame_count: 4, start_frame: 0, every_frames: 1,
    train_frame_count: trainFrames, positions: packed(new Float32Array(12), [4, 1, 3]), ...fields,
  };
  return new Errors(new Prediction(motion, [], scores as readonly Score[]), 4);
}

const tensor = (...values: number[]) => packed(Float32Array.from(values), [values.length]);

describe('errors along time', () => {
  it('have a worst frame, and one of the future', () => {
    const e = errors({ track_m: tensor(0, 0.03, 0.01, 0.02), chamfer_l1_m: tensor(9, 9, 9, 9) });
    expect(e.worst).toEqual({ frame: 1, error: expect.closeTo(0.03) });
    expect(e.worstOfFuture).toEqual({ frame: 3, error: expect.closeTo(0.02) });
    expect(e.curves.map(({ of }) => of)).toEqual(['track', 'chamfer']);
    expect(e.means(e.main!)).toEqual({ train: expect.closeTo(0.03), future: expect.closeTo(0.015) });
  });

  it('are of surfaces where there are no tracks, and of nothing without either', () => {
    const e = errors({ track_m: tensor(NaN, NaN, NaN, NaN), chamfer_l1_m: tensor(NaN, 1, NaN, 0.5) }, [], 4);
    expect([e.main!.of, e.worst!.frame, e.worstOfFuture]).toEqual(['chamfer', 1, null]);
    const nothing = errors({});
    expect([nothing.main, nothing.worst, nothing.curves]).toEqual([null, null, []]);
  });

  it('stand beside those of other predictions, by the same measure', () => {
    const score = (predictor: string, train: number | null, future: number | null) => ({
      predictor, train: { track_m: train, chamfer_l1_m: 7 }, future: { track_m: future, chamfer_l1_m: 7 },
    });
    const scores = [score('bending', 1, 2), score('standing_still', 3, 4), score('last_residual', null, 5), score('axial', null, null)];
    expect(errors({ track_m: tensor(0, 0, 0, 1) }, scores).baselines).toMatchObject([
      { label: 'Standing still', train: 3, future: 4 },
      { label: predictorText('last_residual', false), train: null, future: 5 },
    ]);
  });
});
