import { pointCount, type Skin } from '../view3d/skin';
import type { TwinFile } from './file';
import type { Ground, Model, Rod } from './physics/model';
import type { FastVariant } from './physics/variant';

/** Distance from pi below which a rest angle is pi [rad]. */
const STRAIGHT = 1e-6;
/** Largest step between control points of one hand, where the file does not name hands [m]. */
const HAND_STEP = 0.08;

/** What the header of a twin file says (docs/formats/twin.md, Metadata), as far as it moves. */
interface Document {
  readonly version: number;
  readonly environment: {
    readonly gravity: [number, number, number];
    readonly ground: { readonly normal: [number, number, number]; readonly offset_m: number } | null;
  };
  readonly timing: { readonly fps: number; readonly substeps: number };
  readonly control_velocity: 'true' | 'ignored';
  readonly drag: number;
  readonly contact: {
    readonly ground_restitution: number;
    readonly ground_friction: number;
    readonly object_restitution: number;
    readonly object_friction: number;
    readonly collision_distance_m: number;
    readonly between_objects: boolean;
    readonly within_object: boolean;
    readonly skin?: boolean;
  };
  readonly quality: { readonly fast?: FastVariant };
}

/** The model of a twin file, and its fast variant if it has one. */
export function readModel(file: TwinFile): { model: Model; fast: FastVariant | null } {
  const about = file.document as Document;
  if (!(about.version >= 1 && about.version <= 7)) throw new Error(`twin files of version ${about.version} are not known`);
  const { environment, contact, timing } = about;
  const controls = Float64Array.from(file.floats('controls.rest_position'));
  const hands = file.indices('controls.hand');
  const rest = Float64Array.from(file.floats('nodes.rest_position'));
  const restLengths = Float64Array.from(file.floats('springs.rest_length'));
  const stiffness = file.floats('springs.stiffness');
  const pins = file.indices('pins.ends');
  const model: Model = {
    rest,
    controls,
    hands: hands.length === 0 ? linkedHands(controls) : hands,
    masses: Float64Array.from(file.floats('nodes.mass')),
    objects: file.indices('nodes.object_id'),
    springs: {
      ends: file.indices('springs.ends'),
      rate: restLengths.map((length, s) => (length > 0 ? stiffness[s]! / length : 0)),
      rest: restLengths,
      dashpot: Float64Array.from(file.floats('springs.dashpot')),
    },
    triplets: {
      ends: file.indices('triplets.ends'),
      stiffness: Float64Array.from(file.floats('triplets.bend_stiffness')),
      damping: Float64Array.from(file.floats('triplets.bend_damping')),
      restBend: Float64Array.from(file.floats('triplets.rest_angle'), (angle) =>
        Math.abs(Math.PI - angle) < STRAIGHT ? 0 : Math.PI - angle,
      ),
    },
    rods: readRods(file, new Set(pins.filter((_, i) => i % 2 === 0))),
    pins: {
      nodes: pins.filter((_, i) => i % 2 === 0),
      controls: pins.filter((_, i) => i % 2 === 1),
      offsets: Float64Array.from(file.floats('pins.offset')),
    },
    gravity: environment.gravity,
    ground: readGround(file, about),
    contact: {
      restitution: contact.object_restitution,
      friction: contact.object_friction,
      distance: contact.collision_distance_m,
      betweenObjects: contact.between_objects,
      withinObject: contact.within_object,
    },
    drag: about.drag,
    controlsMove: about.control_velocity === 'true',
    fps: timing.fps,
    substeps: timing.substeps,
  };
  check(model);
  return { model, fast: about.quality.fast ?? null };
}

/** The points of a twin's skin: its surface nodes, if it has no others. */
export function readSkin(file: TwinFile): Skin {
  const skin = file.carried('skin', file.floats('nodes.rest_position').length / 3);
  if (pointCount(skin) > 0) return skin;
  const nodes = Uint32Array.from(file.bytes('nodes.kind').filter((kind) => kind < 2).keys());
  return {
    starts: Uint32Array.from({ length: nodes.length + 1 }, (_, m) => m),
    nodes,
    weights: new Float32Array(nodes.length).fill(1),
    frames: new Uint32Array(3 * nodes.length),
    offsets: new Float32Array(3 * nodes.length),
  };
}

function readGround(file: TwinFile, { environment, contact }: Document): Ground | null {
  if (environment.ground === null) return null;
  return {
    normal: environment.ground.normal,
    offset: environment.ground.offset_m,
    restitution: contact.ground_restitution,
    friction: contact.ground_friction,
    skin: contact.skin === true ? readSkin(file) : null,
  };
}

function readRods(file: TwinFile, pinned: ReadonlySet<number>): Rod[] {
  const nodes = file.indices('rods.nodes');
  const [stiffness, damping] = [file.floats('rods.twist_stiffness'), file.floats('rods.twist_damping')];
  const restTwists = file.floats('rods.rest_twist');
  let start = 0;
  return Array.from(file.indices('rods.lengths'), (length, r) => {
    const own = nodes.subarray(start, (start += length));
    return {
      nodes: own,
      hasArm: !pinned.has(own[own.length - 1]!),
      stiffness: stiffness[r]!,
      damping: damping[r]!,
      restTwist: restTwists[r]!,
    };
  });
}

/** Hands of control points that are linked by short steps, numbered by their first point. */
function linkedHands(controls: Float64Array): Uint32Array {
  const hands = new Uint32Array(controls.length / 3).map((_, c) => c);
  const at = (c: number): Float64Array => controls.subarray(3 * c, 3 * c + 3);
  for (let b = 0; b < hands.length; b += 1) {
    for (let a = 0; a < b; a += 1) {
      const [p, q] = [at(a), at(b)];
      if (Math.hypot(p[0]! - q[0]!, p[1]! - q[1]!, p[2]! - q[2]!) > HAND_STEP) continue;
      const [one, other] = [Math.min(hands[a]!, hands[b]!), Math.max(hands[a]!, hands[b]!)];
      hands.forEach((hand, c) => hand === other && (hands[c] = one));
    }
  }
  return hands;
}

/** Refuses what would be read outside of the arrays. */
function check({ rest, controls, springs, triplets, rods, pins, masses, objects }: Model): void {
  const [nodes, ends] = [rest.length / 3, (rest.length + controls.length) / 3];
  const within = (indices: Uint32Array, count: number): boolean => indices.every((index) => index < count);
  const fits =
    masses.length === nodes && objects.length === nodes &&
    springs.ends.length === 2 * springs.rest.length && springs.dashpot.length === springs.rest.length &&
    springs.rate.every(Number.isFinite) &&
    triplets.ends.length === 3 * triplets.restBend.length &&
    triplets.stiffness.length === triplets.restBend.length && triplets.damping.length === triplets.restBend.length &&
    pins.offsets.length === 3 * pins.nodes.length &&
    within(springs.ends, ends) && within(triplets.ends, ends) && rods.every((rod) => within(rod.nodes, nodes)) &&
    within(pins.nodes, nodes) && within(pins.controls, controls.length / 3);
  if (!fits) throw new Error('the parts of the twin do not belong together');
}
