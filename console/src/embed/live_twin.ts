import { sizeOf } from '../view3d/shape';
import type { TwinFile } from './file';
import { Pace } from './pace';
import type { Model } from './physics/model';
import { pullAt, type Pull } from './physics/pull';
import { Simulator } from './physics/simulator';
import { fastVariant, withoutHands } from './physics/variant';
import { readModel } from './twin';

/** Speed of hands that are dragged, at most [m/s]. */
const HAND_SPEED = 1.5;
/** Radius of what a pull takes hold of, as a share of the object's size. */
const HOLD = 0.12;
/** Speed below which a node is at rest [m/s], and the pictures for which all are before the simulation sleeps. */
const STILL = 2e-3;
const STILL_PICTURES = 60;

/** A twin that is simulated in real time, and pulled. */
export class LiveTwin {
  /** True while its hands hold it as at the start. */
  isHeld: boolean;
  readonly #held: Model;
  readonly #fast;
  readonly #size: number;
  readonly #pace = new Pace();
  #simulator: Simulator;
  #pull: Pull | null = null;
  /** Hand that is dragged, from where to where [m], and where its control points are to be. */
  #hand: { readonly number: number; readonly target: Float64Array; readonly from: Float64Array } | null = null;
  #controls: Float64Array;
  #still = 0;

  constructor(file: TwinFile) {
    const { model, fast } = readModel(file);
    this.#fast = fast;
    this.isHeld = model.controls.length > 0;
    // What nothing would catch does not fall.
    const floats = !this.isHeld && model.ground === null;
    this.#held = floats ? { ...model, gravity: [0, 0, 0] } : model;
    this.#size = sizeOf(Float32Array.from(model.rest));
    this.#controls = model.controls.slice();
    this.#simulator = new Simulator(this.#held);
  }

  get model(): Model {
    return this.#held;
  }

  /** True if it may be let go: something holds it, and the ground catches it. */
  get canFall(): boolean {
    return this.#held.controls.length > 0 && this.#held.ground !== null;
  }

  /** Positions of nodes [m], shape [N, 3]. */
  get nodes(): Float64Array {
    return this.#simulator.x.subarray(0, this.#held.rest.length);
  }

  /** Control points [m], shape [C, 3]. */
  get controls(): Float64Array {
    return this.#controls;
  }

  /** Simulated by real time where that is clearly less than 1, on a slow device; else null. */
  get slowness(): number | null {
    return this.#pace.isSlow ? this.#pace.speed : null;
  }

  get isPulled(): boolean {
    return this.#pull !== null || this.#hand !== null;
  }

  /** True if it lies still, so that nothing has to be simulated. */
  get isStill(): boolean {
    return this.#still >= STILL_PICTURES && !this.isPulled;
  }

  /** Simulates the time since the picture before [s]; false if the motion went out of bounds and began anew. */
  advance(elapsed: number): boolean {
    const simulator = this.#simulator;
    const substeps = this.#pace.take(elapsed, simulator.dt);
    if (substeps === 0) return true;
    if (this.#hand !== null) this.#moveHand(substeps * simulator.dt);
    const begun = performance.now();
    const isFine = simulator.advance(this.isHeld ? this.#controls : new Float64Array(0), substeps, this.#pull);
    this.#pace.took(performance.now() - begun, substeps);
    if (!isFine) this.reset();
    else if (this.#pace.isSlow) this.#simplify();
    this.#still = simulator.v.every((speed) => Math.abs(speed) < STILL) ? this.#still + 1 : 0;
    return isFine;
  }

  /** Takes hold of a node: of the hand that holds it there, or else of the nodes around it. */
  grab(node: number): void {
    this.wake();
    const { x, dt } = this.#simulator;
    const control = this.isHeld ? this.#controlAt(node) : null;
    const at = x.slice(3 * node, 3 * node + 3);
    if (control !== null) this.#hand = { number: this.#held.hands[control]!, target: at, from: at.slice() };
    else this.#pull = pullAt(node, HOLD * this.#size, x, this.#held.masses, dt);
  }

  /** Draws what is held to a place [m]. */
  drag(x: number, y: number, z: number): void {
    (this.#pull ?? this.#hand)?.target.set([x, y, z]);
  }

  /** Releases what was grabbed. */
  release(): void {
    this.#pull = null;
    this.#hand = null;
  }

  /** Lets the hands hold it or not; they hold it again as at the start. */
  hold(isHeld: boolean): void {
    if (isHeld) return this.reset();
    this.release();
    this.wake();
    this.isHeld = false;
    this.#replace(this.#simulator.model);
  }

  /** Begins anew. */
  reset(): void {
    this.release();
    this.wake();
    this.isHeld = this.#held.controls.length > 0;
    this.#controls = this.#held.controls.slice();
    this.#simulator = new Simulator(this.#variant());
  }

  wake(): void {
    this.#still = 0;
  }

  #variant(): Model {
    const isFast = this.#fast !== null && this.#simulator.model.substeps === this.#fast.substeps;
    return isFast ? fastVariant(this.#held, this.#fast) : this.#held;
  }

  /** Continues with the fast variant, if there is one. */
  #simplify(): void {
    if (this.#fast === null || this.#simulator.model.substeps === this.#fast.substeps) return;
    const fast = fastVariant(this.#held, this.#fast);
    this.#replace(fast);
  }

  /** Continues the motion with another model of the twin. */
  #replace(model: Model): void {
    const before = this.#simulator;
    this.#simulator = new Simulator(this.isHeld ? model : withoutHands(model));
    this.#simulator.continue(before);
  }

  /** Control point that a node is pinned to, or joined with by a spring; null without one. */
  #controlAt(node: number): number | null {
    const { pins, springs, masses } = this.#held;
    const pin = pins.nodes.indexOf(node);
    if (pin >= 0) return pins.controls[pin]!;
    for (let s = 0; s < springs.ends.length; s += 2) {
      const [i, j] = [springs.ends[s]!, springs.ends[s + 1]!];
      if (i === node && j >= masses.length) return j - masses.length;
    }
    return null;
  }

  /** Moves the control points of the dragged hand towards its target, for a time [s]. */
  #moveHand(seconds: number): void {
    const { number, target, from } = this.#hand!;
    const [x, y, z] = [target[0]! - from[0]!, target[1]! - from[1]!, target[2]! - from[2]!];
    const share = Math.min(1, (HAND_SPEED * seconds) / Math.max(Math.hypot(x, y, z), 1e-9));
    const step = [share * x, share * y, share * z];
    step.forEach((value, c) => (from[c]! += value));
    this.#held.hands.forEach((hand, control) => {
      if (hand === number) step.forEach((value, c) => (this.#controls[3 * control + c]! += value));
    });
  }
}
