import { base64, packed } from '@bendtwin/client';
import { expect, it } from 'vitest';
import { csvOf } from './recording';

it('lists places and holds of grippers, segment by segment', () => {
  const closed = { dtype: 'UINT32' as const, shape: [2], data: base64(new Uint8Array(new Uint32Array([0, 1]).buffer)) };
  const segment = {
    poses: { poses: packed(new Float32Array([0.1, 0, 0, 0, 0, 0, 1, 0.2, 0, 0, 0, 0, 0, 1]), [1, 2, 1, 7]) },
    grasps: [{ closed }],
  };
  const rows = csvOf({ fps: 10, segments: [segment, segment] }).trimEnd().split('\n');
  expect(rows).toHaveLength(5);
  expect(rows[1]).toBe('0,0,0.0000,0,0.1,0,0,0,0,0,1,0');
  expect(rows[2]).toBe('0,1,0.1000,0,0.2,0,0,0,0,0,1,1');
  expect(rows[4]).toBe('1,1,0.2000,0,0.2,0,0,0,0,0,1,1');
});
