import type { Skin } from '../../view3d/skin';

/** Springs, E of them. */
export interface Springs {
  /** Endpoints: nodes, and then control points; shape [E, 2]. */
  readonly ends: Uint32Array;
  /** Stiffness per rest length [N/m], zero where that is zero. */
  readonly rate: Float64Array;
  /** Lengths at rest [m]. */
  readonly rest: Float64Array;
  /** [N s/m] */
  readonly dashpot: Float64Array;
}

/** Bending triplets i, j, k about the middle one, T of them. */
export interface Triplets {
  /** Endpoints: nodes, and then control points; shape [T, 3]. */
  readonly ends: Uint32Array;
  /** [N m/rad] */
  readonly stiffness: Float64Array;
  /** [N m s/rad] */
  readonly damping: Float64Array;
  /** pi less the angle at rest [rad], exactly zero where straight. */
  readonly restBend: Float64Array;
}

/** A part of a cable with one twist along it. */
export interface Rod {
  readonly nodes: Uint32Array;
  /** True if the last node is that of a branch. */
  readonly hasArm: boolean;
  /** [N m/rad] */
  readonly stiffness: number;
  /** [N m s/rad] */
  readonly damping: number;
  /** [rad] */
  readonly restTwist: number;
}

/** Nodes that control points prescribe, P of them. */
export interface Pins {
  readonly nodes: Uint32Array;
  readonly controls: Uint32Array;
  /** Node minus control point [m], shape [P, 3]. */
  readonly offsets: Float64Array;
}

/** Restitution and Coulomb friction. */
export interface Law {
  readonly restitution: number;
  readonly friction: number;
}

/** Which nodes collide, and how. */
export interface ContactRule extends Law {
  /** Distance below which nodes touch [m]. */
  readonly distance: number;
  readonly betweenObjects: boolean;
  readonly withinObject: boolean;
}

/** The ground: points with normal · x ≥ offset are above it. */
export interface Ground extends Law {
  readonly normal: readonly [number, number, number];
  readonly offset: number;
  /** Points of the skin that meet the ground in place of the nodes, or null. */
  readonly skin: Skin | null;
}

/** All that the motion of a twin follows from, N nodes and C control points: docs/formats/twin.md, The substep. */
export interface Model {
  /** Positions at rest [m], shape [N, 3]. */
  readonly rest: Float64Array;
  /** Control points at rest [m], shape [C, 3]. */
  readonly controls: Float64Array;
  /** Hand of each control point, shape [C]. */
  readonly hands: Uint32Array;
  readonly masses: Float64Array;
  /** Objects that the nodes belong to, shape [N]. */
  readonly objects: Uint32Array;
  readonly springs: Springs;
  readonly triplets: Triplets;
  readonly rods: readonly Rod[];
  readonly pins: Pins;
  /** [m/s²] */
  readonly gravity: readonly [number, number, number];
  readonly ground: Ground | null;
  readonly contact: ContactRule;
  /** Decay rate of velocity [1/s]. */
  readonly drag: number;
  /** True if dashpots know the velocity of control points. */
  readonly controlsMove: boolean;
  /** Frames per second. */
  readonly fps: number;
  /** Substeps per frame. */
  readonly substeps: number;
}

/** Inverse masses, zero for nodes that are pinned; shape [N]. */
export function inverseMasses({ masses, pins }: Model): Float64Array {
  const inverse = masses.map((mass) => 1 / mass);
  pins.nodes.forEach((node) => (inverse[node] = 0));
  return inverse;
}
