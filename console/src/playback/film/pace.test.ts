import { describe, expect, it } from 'vitest';
import { paceOf } from './pace';

describe('the pace of a video', () => {
  it('is that of the recording', () => {
    const { frames, seconds } = paceOf(4, 30, 1);
    expect(frames).toEqual([0, 1, 2, 3]);
    expect(seconds).toBeCloseTo(1 / 30);
  });

  it('leaves out frames that would follow too fast, and no time', () => {
    const { frames, seconds } = paceOf(10, 120, 1);
    expect(frames).toEqual([0, 4, 8]);
    expect(seconds).toBeCloseTo(4 / 120);
    expect(paceOf(4, 30, 2).frames).toEqual([0, 2]);
  });

  it('is slower at a lower speed', () => {
    const { frames, seconds } = paceOf(3, 30, 0.25);
    expect(frames).toEqual([0, 1, 2]);
    expect(seconds).toBeCloseTo(4 / 30);
  });
});
