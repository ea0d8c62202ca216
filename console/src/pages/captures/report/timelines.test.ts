import { expect, test } from 'vitest';

import type { Report } from './report';
import { bandsOf, bandsSummary, summary, timelinesOf } from './timelines';

const CAMERA = {
  name: 'left',
  late_frames: [1, 2],
  mask_jumps: [],
  repeated_frames: [2],
  empty_masks: [3],
  missing_frames: [3, 9],
  object_px: [10, null, 30, 20],
  coverage: [null, null, null, null],
  tracks: null,
};
const REPORT = {
  frame_count: 4,
  cameras: [CAMERA],
  scene: { gap_m: [0.01, 0.0712, null, 0.004] },
  observed: { point_count: 50, visible: [50, 40, 30, 20], motion_valid: [0, 40, 30, 20] },
} as unknown as Report;

test('a frame with several faults shows the worst', () => {
  const bands = bandsOf(REPORT);
  expect(bands).toEqual([{ name: 'left', states: ['fine', 'late', 'repeated', 'missing'] }]);
  expect(bandsSummary(bands)).toBe('Frames of each camera. left: 1 late, 1 repeated, 1 missing.');
});

test('figures without a value are left out', () => {
  const timelines = timelinesOf(REPORT);
  expect(timelines.map(({ title }) => title)).toEqual(['Visible area', 'Tracked points', 'Distance of the hand']);
  expect(timelines[1]).toMatchObject({ top: 50, lines: [{ name: 'seen' }, { name: 'motion trusted' }] });
  expect(timelinesOf({ ...REPORT, frame_count: 1 })).toEqual([]);
});

test('a figure in words names its range and the frames', () => {
  const [area, , hand] = timelinesOf(REPORT);
  expect(summary(area!)).toBe('Visible area, pixels of the object. left: 10 (frame 0) to 30 (frame 2).');
  expect(summary(hand!)).toContain('nearest: 4.0 mm (frame 3) to 71 mm (frame 1)');
});
