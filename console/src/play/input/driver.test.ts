import { Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { Driver } from './driver';
import type { Message, Ready } from '../protocol/messages';
import type { PlayState } from '../protocol/state';

const READY = {
  type: 'ready', play: 'plays/1', twin: 'twins/1', fps: 30, nodes: 4, controls: [], hands: [], mass_kg: null,
  most_colliders: 8, recording: '/v1/plays/1/recording',
  grippers: [{ hand: 0, pose: [0, 0, 0, 0, 0, 0, 1] }, { hand: null, pose: [] }, { hand: null, pose: [] }],
} satisfies Ready;

function state(input: number, holding: boolean[]): PlayState {
  return {
    isPaused: false, isRecording: false, isReplaying: false, isPursuing: false, number: 1, input, strain: 0,
    grippers: holding.map((holds) => ({ position: [1, 2, 3], orientation: [0, 0, 0, 1], force: [0, 0, 0], holds })),
    colliders: new Float32Array(0), positions: new Float32Array(12),
  };
}

function playing(): { driver: Driver; sent: Message[] } {
  const sent: Message[] = [];
  const driver = new Driver((message) => sent.push(message) > 0, 0.02);
  driver.begin(READY);
  driver.see(state(0, [true, false, false]));
  return { driver, sent };
}

describe('Driver', () => {
  it('moves at most one gripper message in ten milliseconds, with the newest places', () => {
    const { driver, sent } = playing();
    for (let i = 0; i < 50; i += 1) driver.move(0, new Vector3(i, 0, 0));
    driver.move(1, new Vector3(0, 7, 0));
    driver.flush();
    expect(sent.length).toBeLessThan(8);
    const last = sent.at(-1);
    expect(last).toMatchObject({ type: 'move', grippers: [{ index: 0, position: [49, 0, 0] }, { index: 1 }] });
    driver.flush();
    expect(sent.at(-1)).toBe(last);
  });

  it('says how long the newest input took that a state has', () => {
    const { driver } = playing();
    driver.grasp(1, 2, 100);
    driver.release(1, 150);
    expect(driver.see(state(0, [true, false, false]))).toBeNull();
    expect(driver.see(state(2, [true, false, false]))).toBe(150);
    expect(driver.see(state(2, [true, false, false]))).toBeNull();
  });

  it('knows which pointers are free, from its inputs until a state includes them', () => {
    const { driver } = playing();
    expect([driver.free(), driver.usable]).toEqual([1, [0, 1]]);
    driver.grasp(1, 2);
    expect([driver.free(), driver.usable]).toEqual([2, [0, 1, 2]]);
    // It reaches for it first.
    driver.see(state(1, [true, false, false]));
    driver.see(state(1, [true, true, false]));
    expect(driver.held.get(1)).toBe(2);
    driver.see(state(1, [true, false, false]));
    expect(driver.held.size).toBe(0);
  });

  it('restores the holds of pointers when a play begins again', () => {
    const { driver, sent } = playing();
    driver.grasp(2, 3);
    driver.see(state(1, [true, false, true]));
    driver.begin(READY);
    expect(sent.filter((message) => message.type === 'grasp')).toHaveLength(2);
    expect(driver.held.get(2)).toBe(3);
  });
});
