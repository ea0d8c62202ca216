import { describe, expect, it } from 'vitest';
import { LEFT, RIGHT, frameAt, mostOf, xOf, type Lane } from './lanes';

const SPAN = { frameCount: 11, fps: 10, trainFrameCount: 5 };

describe('lanes along time', () => {
  it('have a frame for each place, and a place for each frame', () => {
    expect([xOf(0, SPAN, 500), xOf(10, SPAN, 500)]).toEqual([LEFT, 500 - RIGHT]);
    for (const frame of [0, 3, 10]) expect(frameAt(xOf(frame, SPAN, 500) + 4, SPAN, 500)).toBe(frame);
    expect(frameAt(0, SPAN, 500)).toBeLessThan(0);
    expect(xOf(0, { ...SPAN, frameCount: 1 }, 500)).toBe(LEFT);
  });

  it('end above their lines, and above baselines that are not far from these', () => {
    const lane = (train: number | null, future: number | null): Lane => ({
      height: 100, unit: 'mm', scale: 1000, marks: [],
      lines: [{ values: [null, 0.01, 0.004], series: '' }], levels: [{ label: '', train, future, series: '' }],
    });
    expect(mostOf(lane(null, 0.005))).toBe(0.01);
    expect(mostOf(lane(0.015, 0.3))).toBe(0.015);
    expect(mostOf({ ...lane(null, null), lines: [] })).toBeGreaterThan(0);
  });
});
