import { describe, expect, it } from 'vitest';
import { decodeState } from './state';

/** A state as crates/play/src/shown.rs writes it: a gripper, a collider, two nodes. */
function message(): ArrayBuffer {
  const buffer = new ArrayBuffer(36 + 44 + 28 + 12);
  const view = new DataView(buffer);
  const floats = (at: number, values: number[]): void =>
    values.forEach((value, i) => view.setFloat32(at + 4 * i, value, true));
  [1, 1 | 4, 1, 1].forEach((byte, at) => view.setUint8(at, byte));
  view.setUint32(4, 7, true);
  view.setUint32(8, 9, true);
  view.setUint32(12, 2, true);
  floats(16, [1, 2, 3, 0.5, 0.25]);
  floats(36, [0.1, 0.2, 0.3, 0, 0, 0, 1, 4, 5, 6, 1]);
  floats(80, [7, 8, 9, 0, 0, 1, 0]);
  [2, -2, 0, 32766, -32766, 1].forEach((code, i) => view.setInt16(108 + 2 * i, code, true));
  return buffer;
}

describe('decodeState', () => {
  it('reads the server\'s format', () => {
    const state = decodeState(message());
    expect([state.number, state.input, state.strain]).toEqual([7, 9, 0.25]);
    const flags = [state.isPaused, state.isRecording, state.isReplaying, state.isPursuing];
    expect(flags).toEqual([true, false, true, false]);
    expect(state.grippers).toHaveLength(1);
    expect(state.grippers[0]).toMatchObject({ orientation: [0, 0, 0, 1], force: [4, 5, 6], holds: true });
    expect(state.grippers[0]?.position[1]).toBeCloseTo(0.2);
    expect([...state.colliders]).toEqual([7, 8, 9, 0, 0, 1, 0]);
    expect([...state.positions]).toEqual([2, 1, 3, 16384, -16381, 3.5]);
  });

  it('refuses invalid states', () => {
    expect(() => decodeState(new ArrayBuffer(3))).toThrow('cut off');
    expect(() => decodeState(message().slice(0, -1))).toThrow('wrong length');
    const other = message();
    new DataView(other).setUint8(0, 2);
    expect(() => decodeState(other)).toThrow('kind 2');
  });
});
