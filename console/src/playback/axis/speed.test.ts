import { describe, expect, it } from 'vitest';
import { sequence } from '../testing';
import { handSpeeds } from './speed';

const head = (count: number, hands?: number[]) => ({
  ...sequence().motion, control_count: count, ...(hands === undefined ? {} : { control_hands: hands }),
});

describe('the speed of a hand', () => {
  it('is that of the middle of its control points', () => {
    // One point moves 1 cm a frame, the other one stands still.
    const controls = new Float32Array([0, 0, 0, 5, 0, 0, 0.01, 0, 0, 5, 0, 0, 0.02, 0, 0, 5, 0, 0]);
    const [hand, ...others] = handSpeeds(controls, head(2), 30);
    expect(others).toEqual([]);
    expect(hand!.label).toBe('Hand');
    hand!.values.forEach((speed) => expect(speed).toBeCloseTo(0.15, 6));
  });

  it('is that of each hand by itself', () => {
    const controls = new Float32Array([0, 0, 0, 5, 0, 0, 0.01, 0, 0, 5, 0, 0]);
    const hands = handSpeeds(controls, head(2, [1, 0]), 10);
    expect(hands.map(({ label, values }) => [label, values.map((speed) => speed!.toFixed(2))])).toEqual([
      ['Hand 1', ['0.00', '0.00']],
      ['Hand 2', ['0.10', '0.10']],
    ]);
  });

  it('is unknown where points are, and in a single frame', () => {
    const controls = new Float32Array([0, 0, 0, NaN, NaN, NaN, 0, 0, 0.2, 0, 0, 0.3]);
    expect(handSpeeds(controls, head(1), 10)[0]!.values.map((speed) => speed === null)).toEqual([true, false, true, false]);
    expect(handSpeeds(new Float32Array(3), head(1), 10)[0]!.values).toEqual([null]);
    expect(handSpeeds(new Float32Array(0), head(0), 10)).toEqual([]);
  });
});
