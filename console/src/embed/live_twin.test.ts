import { gunzipSync } from 'node:zlib';
import { beforeEach, describe, expect, it, vi } from 'vitest';
import { TwinFile } from './file';
import { LiveTwin } from './live_twin';
import fixture from './physics/motion.fixture.json';

/** A twin of the physics' fixture. */
function twinOf(scene: string): LiveTwin {
  const { twin } = fixture.scenes.find(({ name }) => name === scene)!;
  return new LiveTwin(new TwinFile(new Uint8Array(gunzipSync(Buffer.from(twin, 'base64')))));
}

/** Simulates some seconds in pictures of a sixtieth. */
function play(twin: LiveTwin, seconds: number): void {
  for (let picture = 0; picture < 60 * seconds; picture += 1) expect(twin.advance(1 / 60)).toBe(true);
}

const lowest = (twin: LiveTwin): number => Math.min(...twin.nodes.filter((_, i) => i % 3 === 2));

describe('a twin of a page', () => {
  // As on a device that keeps up, however busy this one is.
  beforeEach(() => void vi.spyOn(performance, 'now').mockReturnValue(0));

  it('is pulled where it is grabbed, and swings back', () => {
    const twin = twinOf('twisted');
    play(twin, 2);
    const before = twin.nodes.slice();
    twin.grab(6);
    expect(twin.isPulled).toBe(true);
    twin.drag(before[18]!, before[19]! + 0.08, before[20]! + 0.08);
    play(twin, 1);
    expect(twin.nodes[20]! - before[20]!).toBeGreaterThan(0.02);
    twin.release();
    play(twin, 4);
    expect(Math.abs(twin.nodes[20]! - before[20]!)).toBeLessThan(0.02);
  });

  it('follows its hand where that is dragged, no faster than a hand', () => {
    const twin = twinOf('twisted');
    const [x, y, z] = twin.nodes.subarray(0, 3) as unknown as [number, number, number];
    twin.grab(0);
    twin.drag(x - 0.5, y, z);
    play(twin, 0.1);
    expect(x - twin.nodes[0]!).toBeGreaterThan(0.1);
    expect(x - twin.nodes[0]!).toBeLessThan(0.2);
    expect(twin.controls[0]! - twin.nodes[0]!).toBeCloseTo(0, 6);
  });

  it('falls when it is let go, and is held as at the start again', () => {
    const twin = twinOf('dragged');
    const start = twin.nodes.slice();
    expect(twin.canFall).toBe(true);
    twin.hold(false);
    play(twin, 1);
    expect(Math.max(...twin.nodes.filter((_, i) => i % 3 === 2))).toBeLessThan(0.03);
    expect(lowest(twin)).toBeGreaterThan(-1e-3);
    twin.hold(true);
    expect(twin.isHeld).toBe(true);
    expect(twin.nodes).toEqual(start);
  });

  it('sleeps when it lies still, and wakes when it is grabbed', () => {
    const twin = twinOf('dragged');
    twin.hold(false);
    play(twin, 5);
    expect(twin.isStill).toBe(true);
    twin.grab(3);
    expect(twin.isStill).toBe(false);
  });
});
