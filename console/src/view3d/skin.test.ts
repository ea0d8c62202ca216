import { describe, expect, it } from 'vitest';
import { NO_FRAME, placeSkin, startsOf, type Skin } from './skin';

const NODES = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
const NONE = [NO_FRAME, NO_FRAME, NO_FRAME];

/** The skin that client/python/tests/test_skin.py places, too. */
const SKIN: Skin = {
  starts: startsOf(new Uint32Array([1, 2, 3])),
  nodes: new Uint32Array([3, 0, 1, 0, 1, 2]),
  weights: new Float32Array([1, 0.5, 0.5, 0.5, 0.25, 0.25]),
  frames: new Uint32Array([...NONE, ...NONE, 0, 1, 2]),
  offsets: new Float32Array([0, 0, 0, 0, 0, 0.5, 0.125, 0.25, 0.5]),
};

function placed(nodes: Float32Array): number[] {
  const out = new Float32Array(9);
  placeSkin(SKIN, nodes, out);
  return Array.from(out, (x) => Math.round(x * 1e6) / 1e6);
}

describe('placeSkin', () => {
  it('puts points where their nodes carry them, as the Python client does', () => {
    expect(placed(NODES)).toEqual([0, 0, 1, 0.5, 0, 0.5, 0.375, 0.5, 0.5]);
  });

  it('turns frames with their nodes, and not the axes of the world', () => {
    // A quarter of a turn about z, then by [1, 2, 3].
    const moved = new Float32Array(12);
    for (let n = 0; n < 4; n += 1) {
      moved[3 * n] = 1 - NODES[3 * n + 1]!;
      moved[3 * n + 1] = 2 + NODES[3 * n]!;
      moved[3 * n + 2] = 3 + NODES[3 * n + 2]!;
    }
    expect(placed(moved)).toEqual([1, 2, 4, 1, 2.5, 3.5, 0.5, 2.375, 3.5]);
  });

  it('gives a frame that collapsed no offset', () => {
    expect(placed(new Float32Array([0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 1])).slice(6)).toEqual([0.75, 0, 0]);
  });
});
