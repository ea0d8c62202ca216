import { base64, type FitPreview } from '@bendtwin/client';
import { expect, test } from 'vitest';
import { errorWords } from '../../parts/error';
import { pointsOf, previewWords, readPreview } from './preview';

const bytes = (values: Int16Array | Uint32Array): string => base64(new Uint8Array(values.buffer));

const REPLY: FitPreview = {
  stage: 'refine',
  variant: 'bending',
  iteration: 3,
  create_time: '2026-01-01T00:00:00Z',
  sequence: 1,
  frames: { dtype: 'UINT32', shape: [2], data: bytes(Uint32Array.of(0, 9)) },
  positions: {
    dtype: 'INT16_SCALED',
    shape: [2, 1, 3],
    data: bytes(Int16Array.of(0, 1, 2, 3, 4, 5)),
    scale: 0.5,
    offset: 1,
  },
  measure: 'track',
  error_m: 0.0083,
  baseline_m: 0.041,
};

test('a preview has the points of each of its frames', () => {
  const preview = readPreview(REPLY);
  expect([preview.sequence, ...preview.frames]).toEqual([1, 0, 9]);
  expect([...pointsOf(preview, 1)]).toEqual([2.5, 3, 3.5]);
  const frames = { dtype: 'UINT32', shape: [4], data: bytes(Uint32Array.of(0, 1, 2, 3)) } as const;
  expect(() => readPreview({ ...REPLY, frames: { ...frames, shape: [4] } })).toThrow('other frames');
});

test('its errors are in millimetres, with their kind', () => {
  expect(previewWords(REPLY)).toBe(
    'Now 8.3 mm (tracks) on the frames that it is being fitted to, standing still 41 mm.',
  );
  expect(previewWords({ ...REPLY, held_back_m: 0.0091 })).toBe(
    'Now 8.3 mm (tracks) on the frames that it is being fitted to, standing still 41 mm. On frames held back: 9.1 mm.',
  );
  expect(previewWords(REPLY, true)).toMatch(/^When it ended 8.3 mm \(tracks\) on the frames that it was being fitted to/);
  expect([errorWords(0.004, null), errorWords(null, 'chamfer')]).toEqual(['4 mm', '– (Chamfer)']);
});
