import { describe, expect, it } from 'vitest';
import { beginOf, readMoment, writeMoment, type Moment } from './moment';

const MOMENT: Moment = {
  positions: new Float32Array([0.1234, -0.5, 1.25, 3, 0, -3]),
  controls: new Float32Array([0.25, 0, 0]),
  dropped: [1],
  world: { gravity: [0, 0, -1], colliders: [{ sphere: { radius_m: 0.1 }, pose: [0, 0, 1, 0, 0, 0, 1] }] },
  vary: { stiffness: 2 },
};

describe('moments', () => {
  it('survive an address to a tenth of a millimetre', () => {
    const query = new URLSearchParams(writeMoment(MOMENT).toString());
    const read = readMoment(query, 2, 1);
    read.positions?.forEach((x, i) => expect(Math.abs(x - MOMENT.positions[i]!)).toBeLessThan(6e-5));
    expect(read).toMatchObject({ dropped: [1], world: MOMENT.world, vary: MOMENT.vary });
    expect([...(read.controls ?? [])]).toEqual([0.25, 0, 0]);
  });

  it('leave out parts of other twins and damaged parts', () => {
    expect(readMoment(writeMoment(MOMENT), 3, 1).positions).toBeUndefined();
    const damaged = new URLSearchParams({ points: '%%%~', world: '{', vary: '[1]', dropped: '1,x,-2' });
    expect(readMoment(damaged, 2, 1)).toEqual({ dropped: [1] });
    expect(writeMoment({ ...MOMENT, positions: new Float32Array(9000) }).has('points')).toBe(false);
  });

  it('begin a play', () => {
    const begin = beginOf(MOMENT) as { initial: { given: { positions: { shape: number[] } } }; dropped: number[] };
    expect(begin.initial.given.positions.shape).toEqual([2, 3]);
    expect(begin.dropped).toEqual([1]);
    expect(beginOf({})).toEqual({ world: {}, vary: {}, dropped: [] });
  });
});
