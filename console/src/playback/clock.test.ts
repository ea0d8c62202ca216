import { describe, expect, it } from 'vitest';
import { Clock } from './clock';

function clock(frames: number, frame = 0): { clock: Clock; shown: number[] } {
  const shown: number[] = [];
  const made: Clock = new Clock(frames, 10, frame, () => shown.push(made.frame));
  return { clock: made, shown };
}

const always = (): boolean => true;

describe('a clock', () => {
  it('shows each frame for its time, and stops at the end', () => {
    const { clock: c, shown } = clock(4);
    c.play();
    for (const now of [0, 50, 100, 199, 200, 350, 1000]) c.tick(now, always);
    expect(shown).toEqual([0, 1, 2, 3]);
    expect(c.isPlaying).toBe(false);
    c.play();
    expect(c.frame).toBe(0);
  });

  it('plays faster and slower', () => {
    const { clock: c } = clock(100);
    c.speed = 4;
    c.play();
    c.tick(0, always);
    c.tick(1000, always);
    expect(c.frame).toBe(40);
    c.speed = 0.1;
    c.tick(2000, always);
    expect(c.frame).toBe(41);
  });

  it('waits for missing frames, and does not catch up', () => {
    const { clock: c } = clock(100);
    c.play();
    c.tick(0, always);
    c.tick(200, () => false);
    c.tick(5000, () => false);
    expect(c.frame).toBe(0);
    c.tick(5010, always);
    expect(c.frame).toBe(1);
  });

  it('stays within its frames', () => {
    const { clock: c } = clock(5, 99);
    expect(c.frame).toBe(4);
    c.step(-2);
    expect(c.frame).toBe(2);
    c.seek(-7);
    expect(c.frame).toBe(0);
    expect(clock(5, Number('x')).clock.frame).toBe(0);
  });

  it('of one frame does not play', () => {
    const { clock: c } = clock(1);
    c.play();
    expect(c.isPlaying).toBe(false);
  });
});
