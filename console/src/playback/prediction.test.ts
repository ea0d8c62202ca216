import { packed } from '@bendtwin/client';
import { describe, expect, it } from 'vitest';
import { Prediction } from './prediction';

const floats = (...values: number[]): Float32Array => Float32Array.from(values);

/** The reply for a sequence of four frames, predicted from the first one on. */
const MOTION = {
  name: '', recording: '', sequence: 0, fps: 30,
  frame_count: 4, start_frame: 0, train_frame_count: 2, every_frames: 1,
};

describe('a prediction', () => {
  it('has the nodes and the errors of its frames', () => {
    const prediction = new Prediction({
      ...MOTION,
      start_frame: 1,
      positions: packed(floats(1, 1, 1, 2, 2, 2, 3, 3, 3), [3, 1, 3]),
      track_m: packed(floats(0, NaN, 0.5), [3]),
    });
    expect(prediction.nodes(0)).toBeNull();
    expect([1, 2, 3, 9].map((frame) => prediction.nodes(frame)![0])).toEqual([1, 2, 3, 3]);
    expect([0, 1, 2, 3, 4].map((frame) => prediction.errors(frame).track)).toEqual([null, 0, null, 0.5, null]);
    expect(prediction.errors(1).chamfer).toBeNull();
  });

  it('of every third frame stays until the next', () => {
    const positions = packed(floats(0, 0, 0, 3, 3, 3), [2, 1, 3]);
    const prediction = new Prediction({ ...MOTION, every_frames: 3, positions });
    expect([0, 2, 3, 5, 6].map((frame) => prediction.nodes(frame)![0])).toEqual([0, 0, 3, 3, 3]);
    expect(prediction.all.map((nodes) => nodes[0])).toEqual([0, 3]);
  });

  it('needs nodes', () => {
    expect(() => new Prediction(MOTION)).toThrow('no nodes');
  });
});
