import { Vector3 } from 'three';
import type { Message, Ready } from '../protocol/messages';
import type { PlayState } from '../protocol/state';

/** Least time between two messages that move something [ms]: the server takes 200 a second of all kinds. */
const MOVE_MS = 10;
/** Inputs whose time is remembered. */
const MOST_INPUTS = 512;
/** States in which a gripper reaches for an object and does not hold it yet. */
const REACHING = 4;

/** Sends messages; false if there is no play. */
export type Send = (message: Message) => boolean;

/**
 * Actions in a play: moves grippers and colliders, grasps, releases. Hands come first, then
 * pointers. Each input has a number; the states say which of them they include.
 */
export class Driver {
  /** The gripper that keys move. */
  selected = 0;
  /** Grippers of the twin's own hands. */
  hands = 0;
  /** Node that each pointer took hold of, while it holds it. */
  readonly held = new Map<number, number>();

  #input = 0;
  #state: PlayState | null = null;
  readonly #targets = new Map<number, Vector3>();
  readonly #colliders = new Map<number, Vector3>();
  readonly #changed = { grippers: new Set<number>(), colliders: new Set<number>() };
  readonly #times = new Map<number, number>();
  /** Grasps that no state has yet. */
  readonly #grasps = new Map<number, { input: number; missed: number }>();
  #sent = 0;
  #movedAt = 0;

  constructor(
    private readonly send: Send,
    private readonly graspRadius: number,
  ) {}

  /** A play has begun: what pointers held they take hold of again. */
  begin(ready: Ready): void {
    this.hands = ready.grippers.filter(({ hand }) => hand !== null).length;
    this.#targets.clear();
    this.#colliders.clear();
    this.#times.clear();
    this.#state = null;
    const held = [...this.held];
    this.held.clear();
    for (const [gripper, node] of held) if (gripper < ready.grippers.length) this.grasp(gripper, node);
  }

  /** Takes in a state; answers the time [ms] of the newest input that is new in it, or null. */
  see(state: PlayState): number | null {
    this.#state = state;
    let newest: number | null = null;
    for (const [input, time] of this.#times) {
      if (input > state.input) break;
      newest = time;
      this.#times.delete(input);
    }
    for (const gripper of this.held.keys()) this.#notice(gripper, state.input);
    return newest;
  }

  /** The last input that was sent. */
  get input(): number {
    return this.#input;
  }

  /** Number of grippers. */
  get count(): number {
    return this.#state?.grippers.length ?? 0;
  }

  /** True if a gripper holds something, as the last state says. */
  isHolding(gripper: number): boolean {
    return this.#state?.grippers[gripper]?.holds ?? false;
  }

  /** Grippers that are of use now: hands, pointers that hold something, and one that is free. */
  get usable(): number[] {
    const all = Array.from({ length: this.count }, (_, g) => g);
    const free = this.free();
    return all.filter((g) => g < this.hands || this.held.has(g) || this.isHolding(g) || g === free);
  }

  /** A pointer that holds nothing, or null. */
  free(): number | null {
    for (let g = this.hands; g < this.count; g += 1) if (!this.held.has(g) && !this.isHolding(g)) return g;
    return null;
  }

  /** Target of a gripper, or its place without one. */
  targetOf(gripper: number): Vector3 {
    const position = this.#state?.grippers[gripper]?.position ?? [0, 0, 0];
    return this.#targets.get(gripper)?.clone() ?? new Vector3(...position);
  }

  /** Place of a gripper. */
  placeOf(gripper: number): Vector3 {
    return new Vector3(...(this.#state?.grippers[gripper]?.position ?? [0, 0, 0]));
  }

  /** Forgets where a gripper was to go, as when something else moves it. */
  forget(gripper: number): void {
    this.#targets.delete(gripper);
  }

  /** Moves a gripper to a place, for an event of this time [ms]. */
  move(gripper: number, to: Vector3, time = performance.now()): void {
    this.#targets.set(gripper, to.clone());
    this.#changed.grippers.add(gripper);
    this.#flushAt(time);
  }

  /** Moves a collider to a place. */
  moveCollider(collider: number, to: Vector3, time = performance.now()): void {
    this.#colliders.set(collider, to.clone());
    this.#changed.colliders.add(collider);
    this.#flushAt(time);
  }

  /** Lets a gripper take hold of a node and of those near it. */
  grasp(gripper: number, node: number, time = performance.now()): void {
    const input = this.#next(time);
    this.#targets.delete(gripper);
    if (this.send({ type: 'grasp', input, gripper, node, radius_m: this.graspRadius })) {
      if (gripper >= this.hands) this.held.set(gripper, node);
      this.#grasps.set(gripper, { input, missed: 0 });
    }
  }

  /** Makes a gripper release what it holds. */
  release(gripper: number, time = performance.now()): void {
    this.flush();
    this.send({ type: 'release', input: this.#next(time), gripper });
    this.held.delete(gripper);
    this.#targets.delete(gripper);
  }

  /** Sends what has moved since the last message. */
  flush(now = performance.now()): void {
    const { grippers, colliders } = this.#changed;
    if (grippers.size + colliders.size === 0) return;
    const places = (of: Map<number, Vector3>, changed: Set<number>): { index: number; position: number[] }[] =>
      [...changed].flatMap((index) => {
        const place = of.get(index);
        return place === undefined ? [] : [{ index, position: place.toArray() }];
      });
    const input = this.#next(this.#movedAt);
    const moved = {
      grippers: places(this.#targets, grippers),
      colliders: places(this.#colliders, colliders),
    };
    grippers.clear();
    colliders.clear();
    this.#sent = now;
    this.send({ type: 'move', input, ...moved });
  }

  /** Number of another input, at a time [ms]. */
  #next(time: number): number {
    this.#input += 1;
    this.#times.set(this.#input, time);
    if (this.#times.size > MOST_INPUTS) this.#times.delete(this.#times.keys().next().value ?? 0);
    return this.#input;
  }

  /** Sends immediately, or with the next frame if something was sent just now. */
  #flushAt(time: number): void {
    if (this.#changed.grippers.size + this.#changed.colliders.size === 1) this.#movedAt = time;
    if (performance.now() - this.#sent >= MOVE_MS) this.flush();
  }

  /** Notes whether a pointer still holds what it took. */
  #notice(gripper: number, input: number): void {
    const grasp = this.#grasps.get(gripper);
    if (this.isHolding(gripper)) this.#grasps.delete(gripper);
    else if (grasp === undefined) this.held.delete(gripper);
    else if (input >= grasp.input && (grasp.missed += 1) > REACHING) this.held.delete(gripper);
  }
}
