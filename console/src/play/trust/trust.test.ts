import { expect, it } from 'vitest';
import type { TwinShape } from '../../view3d/shape';
import type { PlayState } from '../protocol/state';
import { Trust } from './trust';

const SHAPE = {
  rest: new Float32Array([0, 0, 0, 1, 0, 0]), springs: Uint32Array.of(0, 1), restLengths: Float32Array.of(1),
} as TwinShape;

function state(length: number): PlayState {
  return { strain: Math.abs(length - 1), positions: new Float32Array([0, 0, 0, length, 0, 0]) } as PlayState;
}

it('asks for the recorded range once something is strained, and keeps a warning until it can be read', async () => {
  let asked = 0;
  const trust = new Trust(SHAPE, () => {
    asked += 1;
    return Promise.resolve({ stretched: 0.1, compressed: 0.1 });
  });
  expect([trust.judge(state(1.01), null, 0), asked]).toEqual([null, 0]);
  expect([trust.judge(state(1.3), null, 0), asked, trust.warning]).toEqual([null, 1, '']);
  await Promise.resolve();
  expect([...trust.judge(state(1.3), null, 2000)!]).toEqual([1, 1]);
  expect([asked, trust.warning]).toEqual([1, 'Stretched 3 times beyond anything recorded: do not trust this.']);
  expect(trust.judge(state(1.05), null, 2500)).toBeNull();
  expect(trust.warning).not.toBe('');
  trust.judge(state(1.05), null, 4000);
  expect(trust.warning).toBe('');
});

it('says nothing where no range can be found', async () => {
  const trust = new Trust(SHAPE, () => Promise.reject(new Error('the capture is gone')));
  trust.judge(state(2), null, 0);
  await Promise.resolve();
  expect([trust.judge(state(2), 400, 2000), trust.warning]).toEqual([null, '']);
});
