import { describe, expect, it } from 'vitest';
import { Motion, carry } from './motion';
import type { PlayState } from './protocol/state';

function state(x: number, colliders = 0): PlayState {
  return {
    isPaused: false, isRecording: false, isReplaying: false, isPursuing: false, number: 1, input: 0, strain: 0,
    grippers: [{ position: [x, 0, 0], orientation: [0, 0, 0, 1], force: [0, 0, 0], holds: true }],
    colliders: new Float32Array(7 * colliders), positions: new Float32Array([x, 0, 1]),
  };
}

describe('Motion', () => {
  it('moves from the shown state to the last one in the time between states', () => {
    const motion = new Motion();
    motion.push(state(0), 0);
    expect(motion.sample(0)).toBe(true);
    for (let i = 1; i <= 20; i += 1) motion.push(state(0), 40 * i);
    motion.push(state(1), 840);
    motion.sample(860);
    expect(motion.shown.positions[0]).toBeCloseTo(0.5, 1);
    expect(motion.shown.grippers[0]).toBeCloseTo(0.5, 1);
    // A state that comes on the way is gone to from there: nothing jumps.
    const before = motion.shown.positions[0]!;
    motion.push(state(2), 860);
    motion.sample(861);
    expect(motion.shown.positions[0]! - before).toBeLessThan(0.15);
    expect(motion.sample(2000)).toBe(false);
    expect(motion.shown.positions[0]).toBe(2);
  });

  it('shows a part of a state in the first picture after it', () => {
    const motion = new Motion();
    motion.push(state(0), 0);
    motion.push(state(1), 33);
    motion.sample(30);
    expect(motion.shown.positions[0]).toBeGreaterThan(0);
  });

  it('jumps where there are other things than before', () => {
    const motion = new Motion();
    motion.push(state(0), 0);
    motion.push(state(1, 1), 33);
    motion.sample(34);
    expect(motion.shown.positions[0]).toBe(1);
    expect(motion.shown.colliders).toHaveLength(7);
  });
});

describe('carry', () => {
  it('moves and turns control points with their hands', () => {
    const out = new Float32Array(6);
    const half = Math.SQRT1_2;
    // Hand 0 stays; hand 1 moves up by 1 and makes a quarter of a turn about z.
    const grippers = new Float32Array([0, 0, 0, 0, 0, 0, 1, 1, 0, 1, 0, 0, half, half]);
    carry([[0.5, 0, 0], [1.5, 0, 0]], [0, 1], [[0, 0, 0], [1, 0, 0]], grippers, out);
    const expected = [0.5, 0, 0, 1, 0.5, 1];
    out.forEach((x, i) => expect(x).toBeCloseTo(expected[i]!));
  });
});
