import type { Collider, World } from '@bendtwin/client';
import { planeOf, type Plane } from '../view3d/shape';
import type { Factors } from './protocol/messages';

/** The world of a play as one changes it: gravity, ground, obstacles, factors of the twin's parameters. */
export class WorldModel {
  /** Size of gravity, as a factor of the twin's own. */
  gravity = 1;
  /** Height of the ground above the twin's own [m]; null: none. */
  ground: number | null = 0;
  vary: Factors = {};
  colliders: Collider[] = [];

  /** `own` are gravity [m/s^2] and ground of the twin. */
  constructor(private readonly own: { readonly gravity: readonly number[]; readonly ground: Plane | null }) {
    if (own.ground === null) this.ground = null;
  }

  /** The world as messages have it; what is as in the twin is left out. */
  get world(): World {
    const { own } = this;
    return {
      ...(this.gravity === 1 ? {} : { gravity: own.gravity.map((g) => g * this.gravity) }),
      ...this.#ground(),
      ...(this.colliders.length === 0 ? {} : { colliders: this.colliders }),
    };
  }

  /** Takes over a world that is in force. */
  adopt(world: World, vary: Factors): void {
    const size = (v: readonly number[]): number => Math.hypot(...v);
    const own = size(this.own.gravity);
    this.gravity = world.gravity === undefined || own === 0 ? 1 : size(world.gravity) / own;
    this.ground = heightOf(world, this.own.ground);
    this.vary = { ...vary };
    this.colliders = [...(world.colliders ?? [])];
  }

  /** Puts an obstacle in. */
  add(collider: Collider): void {
    this.colliders = [...this.colliders, collider];
  }

  /** Moves an obstacle to a place [m]. */
  moveTo(index: number, place: readonly number[]): void {
    this.colliders = this.colliders.map((collider, c) => {
      const turn = (collider.pose ?? [0, 0, 0, 0, 0, 0, 1]).slice(3);
      return c === index ? { ...collider, pose: [...place, ...turn] } : collider;
    });
  }

  /** Takes an obstacle out. */
  remove(index: number): void {
    this.colliders = this.colliders.filter((_, c) => c !== index);
  }

  #ground(): Pick<World, 'ground' | 'no_ground'> {
    const { own, ground } = this;
    if (ground === null) return own.ground === null ? {} : { no_ground: true };
    if (ground === 0 && own.ground !== null) return {};
    return { ground: { normal: [...(own.ground?.normal ?? [0, 0, 1])], offset_m: (own.ground?.offset_m ?? 0) + ground } };
  }
}

function heightOf(world: World, own: Plane | null): number | null {
  if (world.no_ground === true) return null;
  if (world.ground !== undefined) return planeOf(world.ground).offset_m - (own?.offset_m ?? 0);
  return own === null ? null : 0;
}
