import { Contact } from './contact';
import { findClearance, travel } from './ground';
import { inverseMasses, type Model } from './model';
import { addPull, type Pull } from './pull';
import { Rods } from './rods';
import { addSpringForces } from './springs';
import { addTripletForces } from './triplets';

/** Coordinate beyond which a motion has diverged [m]. */
const FARTHEST = 1000;

/**
 * The motion of a twin: semi-implicit Euler in the order of docs/formats/twin.md, The substep, which is that of the
 * engine (`crates/engine/src/cpu/frame/integrate.rs`), in double precision.
 */
export class Simulator {
  /** Positions [m] and velocities [m/s] of nodes and then control points, shape [N + C, 3]. */
  readonly x: Float64Array;
  readonly v: Float64Array;
  readonly #forces: Float64Array;
  /** Velocities after forces and contact, shape [N, 3]. */
  readonly #moved: Float64Array;
  /** Control points at the start of a frame, shape [C, 3]. */
  readonly #from: Float64Array;
  readonly #clearance: Float64Array;
  readonly #inverse: Float64Array;
  readonly #rods: Rods;
  readonly #contact: Contact;

  constructor(readonly model: Model) {
    const [nodes, controls] = [model.rest.length, model.controls.length];
    this.x = new Float64Array(nodes + controls);
    this.v = new Float64Array(nodes + controls);
    this.#forces = new Float64Array(nodes + controls);
    this.#moved = new Float64Array(nodes);
    this.#from = new Float64Array(controls);
    this.#clearance = new Float64Array(nodes / 3);
    this.#inverse = inverseMasses(model);
    this.#rods = new Rods(model.rods);
    this.#contact = new Contact(model);
    this.x.set(model.rest);
    this.x.set(model.controls, nodes);
  }

  /** Length of a substep [s]. */
  get dt(): number {
    return 1 / (this.model.fps * this.model.substeps);
  }

  /** Takes the state of another simulator of the same nodes, in which control points may be missing. */
  continue(other: Simulator): void {
    const nodes = this.model.rest.length;
    this.x.set(other.x.subarray(0, nodes));
    this.v.set(other.v.subarray(0, nodes));
    if (other.x.length === this.x.length) this.x.set(other.x.subarray(nodes), nodes);
    if (other.#rods.twists.length === this.#rods.twists.length) this.#rods.twists.set(other.#rods.twists);
  }

  /**
   * Advances by a number of substeps, by default a frame, in which control points move evenly to `controls` [C, 3]; false
   * if the motion has diverged.
   */
  advance(controls: Float64Array, substeps = this.model.substeps, pull: Pull | null = null): boolean {
    const { x, v, model } = this;
    const nodes = model.rest.length;
    this.#from.set(x.subarray(nodes));
    const rate = model.controlsMove ? 1 / (substeps * this.dt) : 0;
    for (let c = 0; c < controls.length; c += 1) v[nodes + c] = (controls[c]! - this.#from[c]!) * rate;
    this.#pin(x, v);
    this.#contact.findPairs(x, v);
    findClearance(model.ground, x, this.#clearance);
    for (let s = 1; s <= substeps; s += 1) this.#substep(controls, s / substeps, pull);
    return x.every((value) => Math.abs(value) <= FARTHEST);
  }

  #substep(controls: Float64Array, progress: number, pull: Pull | null): void {
    const { x, v, model, dt } = this;
    const moved = this.#moved;
    const nodes = moved.length;
    for (let c = 0; c < controls.length; c += 1) {
      x[nodes + c] = (1 - progress) * this.#from[c]! + progress * controls[c]!;
    }
    const forces = this.#forces.fill(0);
    addSpringForces(model.springs, x, v, forces);
    addTripletForces(model.triplets, x, v, forces);
    this.#rods.addForces(dt, x, v, forces);
    if (pull !== null) addPull(pull, x, v, forces);
    const decay = Math.exp(-model.drag * dt);
    const { gravity } = model;
    for (let i = 0; i < nodes; i += 1) {
      const acceleration = forces[i]! * this.#inverse[(i / 3) | 0]! + gravity[i % 3]!;
      moved[i] = (v[i]! + acceleration * dt) * decay;
    }
    this.#pin(null, moved);
    this.#contact.collide(x, v, moved);
    travel(model.ground, this.#clearance, dt, x, v, moved);
    v.set(moved);
    this.#pin(x, v);
  }

  /** Gives pinned nodes the velocities of their control points, and sets them there. */
  #pin(x: Float64Array | null, v: Float64Array): void {
    const { pins, rest } = this.model;
    for (let p = 0; p < pins.nodes.length; p += 1) {
      const node = 3 * pins.nodes[p]!;
      const control = rest.length + 3 * pins.controls[p]!;
      for (let c = 0; c < 3; c += 1) {
        v[node + c] = this.v[control + c]!;
        if (x !== null) x[node + c] = this.x[control + c]! + pins.offsets[3 * p + c]!;
      }
    }
  }
}
