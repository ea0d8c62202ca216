import { expect, it } from 'vitest';
import type { Model } from './model';
import { addPull, pullAt } from './pull';
import { Simulator } from './simulator';
import { fastVariant, withoutHands } from './variant';

/** Three nodes on a line, 10 cm apart, the first held by a pin and the second by a spring to another control point. */
const MODEL: Model = {
  rest: new Float64Array([0, 0, 1, 0.1, 0, 1, 0.2, 0, 1]),
  controls: new Float64Array([0, 0, 1, 0.1, 0, 1.05]),
  hands: new Uint32Array([0, 0]),
  masses: new Float64Array([1, 1, 1]),
  objects: new Uint32Array(3),
  springs: {
    ends: new Uint32Array([0, 1, 1, 2, 1, 4]),
    rate: new Float64Array([5000, 5000, 200]),
    rest: new Float64Array([0.1, 0.1, 0.05]),
    dashpot: new Float64Array([5, 5, 1]),
  },
  triplets: {
    ends: new Uint32Array([0, 1, 2]),
    stiffness: new Float64Array([0.5]),
    damping: new Float64Array([0.01]),
    restBend: new Float64Array([0]),
  },
  rods: [],
  pins: { nodes: new Uint32Array([0]), controls: new Uint32Array([0]), offsets: new Float64Array(3) },
  gravity: [0, 0, -9.81],
  ground: { normal: [0, 0, 1], offset: 0, restitution: 0.3, friction: 0.5, skin: null },
  contact: { distance: 0.02, betweenObjects: false, withinObject: false, restitution: 0.5, friction: 0.3 },
  drag: 1,
  controlsMove: true,
  fps: 30,
  substeps: 100,
};

it('draws nodes to the pointer, by a force that is bounded', () => {
  const simulator = new Simulator(MODEL);
  const pull = pullAt(2, 0.05, simulator.x, MODEL.masses, simulator.dt);
  pull.target.set([0.2, 0.05, 1]);
  for (let frame = 0; frame < 60; frame += 1) simulator.advance(MODEL.controls, MODEL.substeps, pull);
  const bent = simulator.x[7]!;
  expect(bent).toBeGreaterThan(0.02);
  pull.target.set([0.2, 50, 1]);
  const forces = new Float64Array(15);
  addPull(pull, simulator.x, new Float64Array(15), forces);
  expect(Math.hypot(...forces)).toBeCloseTo(pull.most, 6);
  for (let frame = 0; frame < 60; frame += 1) {
    expect(simulator.advance(MODEL.controls, MODEL.substeps, pull)).toBe(true);
  }
  expect(simulator.x[7]!).toBeLessThan(0.5);
});

it('shares a pull among nodes near by, and stays stable with long substeps', () => {
  const x = Float64Array.from([...MODEL.rest, ...MODEL.controls]);
  const pull = pullAt(1, 0.15, x, MODEL.masses, 1 / 60);
  expect([...pull.nodes]).toEqual([0, 1, 2]);
  expect(pull.shares.reduce((sum, share) => sum + share, 0)).toBeCloseTo(1, 12);
  expect(pull.shares[1]).toBeGreaterThan(2 * pull.shares[0]!);
  const frequencies = pull.stiffness.map((stiffness, k) => Math.sqrt(stiffness / MODEL.masses[pull.nodes[k]!]!));
  expect(Math.max(...frequencies) / 60).toBeLessThan(0.5);
});

it('falls to the ground without hands, and continues where it was', () => {
  const held = new Simulator(MODEL);
  for (let frame = 0; frame < 60; frame += 1) held.advance(MODEL.controls);
  expect(held.x[2]).toBe(1);
  const free = new Simulator(withoutHands(MODEL));
  expect(free.model.springs.ends).toEqual(new Uint32Array([0, 1, 1, 2]));
  free.continue(held);
  expect(free.x[8]).toBe(held.x[8]);
  for (let frame = 0; frame < 60; frame += 1) free.advance(new Float64Array(0));
  expect(Math.max(free.x[2]!, free.x[5]!, free.x[8]!)).toBeLessThan(0.2);
  expect(Math.min(free.x[2]!, free.x[5]!, free.x[8]!)).toBeGreaterThan(-1e-6);
});

it('softens what fewer substeps would make unstable', () => {
  const soft = fastVariant(MODEL, { substeps: 2, rate_limit: 0.4 });
  const dt = 1 / 60;
  // The first end of the first spring is pinned, both ends of the second are free.
  expect(soft.springs.rate[0]).toBeCloseTo(0.4 / (dt * dt), 9);
  expect(soft.springs.rate[1]).toBeCloseTo(0.4 / (2 * dt * dt), 9);
  expect(soft.springs.rate[2]).toBe(200);
  expect(soft.springs.dashpot[1]).toBe(5);
  expect(soft.triplets.stiffness[0]).toBe(0.5);
  expect(fastVariant(MODEL, { substeps: 50 }).springs).toBe(MODEL.springs);
  const simulator = new Simulator(soft);
  for (let frame = 0; frame < 300; frame += 1) expect(simulator.advance(MODEL.controls)).toBe(true);
});
