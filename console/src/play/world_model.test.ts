import { expect, it } from 'vitest';
import { WorldModel } from './world_model';

const OWN = { gravity: [0, 0, -10], ground: { normal: [0, 0, 1] as const, offset_m: 0.5 } };

it('leaves out values equal to the twin\'s', () => {
  expect(new WorldModel(OWN).world).toEqual({});
  expect(new WorldModel({ ...OWN, ground: null }).world).toEqual({});
});

it('reports changes, and takes them over again', () => {
  const model = new WorldModel(OWN);
  model.gravity = 0.5;
  model.ground = 0.2;
  model.vary = { stiffness: 2 };
  model.add({ sphere: { radius_m: 0.1 } });
  model.moveTo(0, [1, 2, 3]);
  expect(model.world).toEqual({
    gravity: [0, 0, -5],
    ground: { normal: [0, 0, 1], offset_m: 0.7 },
    colliders: [{ sphere: { radius_m: 0.1 }, pose: [1, 2, 3, 0, 0, 0, 1] }],
  });
  const other = new WorldModel(OWN);
  other.adopt(model.world, model.vary);
  expect(other.gravity).toBe(0.5);
  expect(other.ground).toBeCloseTo(0.2);
  expect(other.colliders).toEqual(model.colliders);
  other.remove(0);
  other.ground = null;
  expect(other.world).toEqual({ gravity: [0, 0, -5], no_ground: true });
  other.adopt({}, {});
  expect(other.world).toEqual({});
});
