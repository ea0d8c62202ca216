import type { Collider } from '@bendtwin/client';
import { Quaternion, Vector3 } from 'three';
import { h } from '../ui/dom';
import { ArrowsLayer, type Arrow } from '../view3d/layers/arrows';
import { CollidersLayer } from '../view3d/layers/colliders';
import { GRIPPER_MIDDLE, HandsLayer } from '../view3d/layers/hands';
import { Legend } from '../view3d/legend';
import { Ground } from '../view3d/place/ground';
import { planeOf, sizeOf, type TwinShape } from '../view3d/shape';
import { Stage } from '../view3d/stage';
import { TwinView } from '../view3d/twin_view';
import type { Driver } from './input/driver';
import { GoalLayer } from './goal_layer';
import type { Facts, Ready } from './protocol/messages';
import { Motion, carry } from './motion';
import type { PlayState } from './protocol/state';
import type { Trust } from './trust/trust';
import { forceOf } from './trust/words';

/** The least force that is shown [N]. */
const LEAST_FORCE = 0.02;

/** Picture of a play: the twin, hands, forces, obstacles, the ground, a goal. */
export class PlayScene {
  readonly stage: Stage;
  readonly twin: TwinView;
  readonly goal: GoalLayer;
  readonly ground: Ground;
  readonly colliders: CollidersLayer;
  readonly motion = new Motion();
  /** The size of the object at rest [m]. */
  readonly size: number;
  /** Radius of a hand [m]. */
  readonly handRadius: number;
  state: PlayState | null = null;
  selectedCollider: number | null = null;
  showsForces = true;

  readonly #shape: TwinShape;
  readonly #hands: HandsLayer;
  readonly #arrows: ArrowsLayer;
  readonly #labels = h('div', { class: 'force-labels', 'aria-hidden': 'true' });
  readonly #excess = h('p', { class: 'play-excess', hidden: true }, h('span', { class: 'play-stripes' }), 'beyond anything recorded');
  readonly #controls: Float32Array;
  #ready: Ready | null = null;
  #forceScale = 0;

  constructor(shape: TwinShape, label: string, private readonly trust: Trust) {
    this.#shape = shape;
    this.stage = new Stage(label, 'application');
    const legend = new Legend();
    this.stage.overlay.append(this.#labels, h('div', { class: 'play-legends' }, this.#excess, legend.element));
    this.size = sizeOf(shape.rest);
    this.handRadius = Math.min(Math.max(0.022 * this.size, 0.5 * shape.spacing), 0.05);
    this.ground = new Ground(this.stage, shape.rest);
    this.twin = new TwinView(this.stage, shape, legend);
    this.#hands = this.stage.add(new HandsLayer(this.handRadius));
    this.#arrows = this.stage.add(new ArrowsLayer(0.22 * this.handRadius));
    this.colliders = this.stage.add(new CollidersLayer());
    this.goal = this.stage.add(new GoalLayer(0.8 * this.handRadius));
    this.#controls = shape.controls.slice();
    this.#lie({});
  }

  /** Displayed control points [m], shape [C, 3]. */
  get controls(): Float32Array {
    return this.#controls;
  }

  /** A play has begun. */
  begin(ready: Ready): void {
    this.#ready = ready;
  }

  /** Takes over the world of a play. */
  surround({ world }: Facts): void {
    this.colliders.set(world.colliders ?? []);
    this.#lie(world);
  }

  /** Shows these obstacles until the server has them. */
  put(colliders: readonly Collider[]): void {
    this.colliders.set(colliders);
    this.stage.invalidate();
  }

  /** Takes in a state that has come. */
  push(state: PlayState): void {
    this.state = state;
    this.motion.push(state, performance.now());
    const forces = state.grippers.map(({ force, holds }) => (holds ? Math.hypot(...force) : 0));
    const beyond = this.trust.judge(state, this.#weight > 0 ? Math.max(...forces, 0) / this.#weight : null);
    this.#excess.hidden = !this.twin.warn(beyond);
    this.stage.invalidate();
  }

  /** Places everything for a picture; true while it moves. */
  draw(now: number, driver: Driver): boolean {
    const { state } = this;
    if (state === null || state.positions.length !== this.#shape.rest.length) return false;
    const moves = this.motion.sample(now);
    const { positions, grippers, colliders } = this.motion.shown;
    const ready = this.#ready;
    if (ready !== null) {
      const first = ready.grippers.map(({ pose }) => pose);
      carry(ready.controls, ready.hands, first, grippers, this.#controls);
    }
    const hands = this.#shape.hands;
    this.twin.place(positions, this.#controls, (c) => state.grippers[hands[c]!]?.holds ?? true);
    this.colliders.place(colliders, this.selectedCollider);
    this.goal.place(positions);
    const closes = this.#drawHands(grippers, driver);
    this.#drawForces(grippers);
    return moves || closes;
  }

  /** Displayed place of a gripper [m]. */
  gripper(index: number): Vector3 {
    return new Vector3().fromArray(this.motion.shown.grippers, 7 * index);
  }

  /** Displayed middle of the body of a gripper [m]. */
  gripperMiddle(index: number): Vector3 {
    return new Vector3(0, 0, GRIPPER_MIDDLE * this.handRadius).applyQuaternion(this.#turn(index)).add(this.gripper(index));
  }

  /** Displayed place of a node [m]. */
  node(index: number): Vector3 {
    return new Vector3().fromArray(this.motion.shown.positions, 3 * index);
  }

  /** The node that is nearest to a place, or null without any. */
  nearest(to: Vector3): number | null {
    const { positions } = this.motion.shown;
    let [best, found] = [Infinity, null as number | null];
    for (let n = 0; n < positions.length / 3; n += 1) {
      const distance = this.node(n).distanceToSquared(to);
      if (distance < best) [best, found] = [distance, n];
    }
    return found;
  }

  dispose(): void {
    this.twin.dispose();
    this.stage.dispose();
  }

  #turn(gripper: number): Quaternion {
    const turn = new Quaternion().fromArray(this.motion.shown.grippers, 7 * gripper + 3);
    return turn.lengthSq() > 0 ? turn.normalize() : turn.identity();
  }

  #drawHands(grippers: Float32Array, driver: Driver): boolean {
    const usable = new Set(driver.usable);
    const hands = Array.from({ length: grippers.length / 7 }, (_, g) => ({
      position: this.gripper(g),
      turn: this.#turn(g),
      holds: driver.isHolding(g),
      selected: g === driver.selected,
      visible: g < driver.hands || driver.isHolding(g) || (usable.has(g) && g === driver.selected),
    }));
    return this.#hands.place(hands);
  }

  #drawForces(grippers: Float32Array): void {
    const forces = this.showsForces ? (this.state?.grippers ?? []) : [];
    const sizes = forces.map(({ force, holds }) => (holds ? Math.hypot(...force) : 0));
    // The strongest one lately has a third of the object's length; it fades, so that weak ones come to be seen.
    this.#forceScale = Math.max(0.995 * this.#forceScale, ...sizes, LEAST_FORCE);
    const arrows: Arrow[] = [];
    const labels: HTMLElement[] = [];
    sizes.forEach((size, g) => {
      if (size < Math.max(LEAST_FORCE, 0.02 * this.#forceScale) || 7 * g + 6 >= grippers.length) return;
      const way = new Vector3(...forces[g]!.force).multiplyScalar((0.3 * this.size) / this.#forceScale);
      const from = this.gripper(g);
      arrows.push({ from, way });
      const at = this.stage.project(from.clone().add(way));
      if (at === null) return;
      const label = h('span', {}, forceOf(size, this.#weight, this.#shape.massKg !== null));
      const { clientWidth, clientHeight } = this.stage.canvas;
      const [x, y] = [Math.min(Math.max(at.x, 4), clientWidth - 150), Math.min(Math.max(at.y, 4), clientHeight - 24)];
      label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      labels.push(label);
    });
    this.#arrows.place(arrows);
    this.#labels.replaceChildren(...labels);
  }

  /** Weight of the object, in newtons or relative as forces are; 0 without gravity. */
  get #weight(): number {
    const { mass, gravity } = this.#shape;
    return mass * Math.hypot(...gravity);
  }

  #lie(world: Facts['world']): void {
    const own = this.#shape.ground;
    const plane = world.no_ground === true ? null : world.ground === undefined ? own : planeOf(world.ground);
    this.ground.place(plane);
    this.twin.above(plane);
    this.stage.invalidate();
  }
}
