// A twin file (docs/formats/twin.md) from a description by hand; numbers that do not matter are made up.

/** Stands for no observed point, and for the axes of the world. */
const NONE = 0xffffffff;

/**
 * @typedef {object} Twin
 * @property {number[][]} nodes At rest [m].
 * @property {number[][]} controls At rest [m].
 * @property {number[][]} springs
 * @property {number[][]} triplets
 * @property {number[][]} [pins]
 * @property {number[][]} [rods]
 * @property {number[]} [objects]
 * @property {{ counts: number[], nodes: number[], weights: number[], drop: number }} [skin] Points below nodes.
 * @property {object} [contact]
 * @property {object} [ground]
 * @property {string} [velocity]
 */

/**
 * @param {Twin} twin
 * @returns {Buffer}
 */
export function twinFile({ nodes, controls, springs, triplets, pins = [], rods = [], objects, skin, contact, ground, velocity }) {
  const points = nodes.concat(controls).map((point) => point.map(Math.fround));
  const random = randomly();
  const at = (/** @type {number | undefined} */ end) => /** @type {number[]} */ (points[Number(end)]);
  const some = (/** @type {number} */ count, /** @type {number} */ low, /** @type {number} */ high) =>
    floats(Array.from({ length: count }, () => low + (high - low) * random()));
  const same = (/** @type {number} */ count, /** @type {number} */ value) => floats(Array(count).fill(value));
  const surface = skin ?? { counts: nodes.map(() => 1), nodes: nodes.map((_, n) => n), weights: nodes.map(() => 1), drop: 0 };
  const count = surface.counts.length;
  /** @type {Record<string, Tensor>} */
  const tensors = {
    'nodes.rest_position': floats(nodes.flat(), 3),
    'nodes.kind': { dtype: 'U8', width: 1, values: new Uint8Array(nodes.length) },
    'nodes.mass': some(nodes.length, 0.5, 2),
    'nodes.object_id': indices(objects ?? nodes.map(() => 0)),
    'nodes.observed_point': indices(nodes.map(() => NONE)),
    'controls.rest_position': floats(controls.flat(), 3),
    'springs.ends': indices(springs.flat(), 2),
    'springs.rest_length': floats(springs.map(([i, j]) => Math.hypot(...minus(at(j), at(i))))),
    'springs.stiffness': some(springs.length, 500, 1500),
    'springs.dashpot': some(springs.length, 0.5, 2),
    'triplets.ends': indices(triplets.flat(), 3),
    'triplets.rest_angle': floats(triplets.map(([i, j, k]) => angle(minus(at(i), at(j)), minus(at(k), at(j))))),
    'triplets.bend_stiffness': some(triplets.length, 0.02, 0.06),
    'triplets.bend_damping': some(triplets.length, 1e-4, 1e-3),
    'pins.ends': indices(pins.flat(), 2),
    'pins.offset': floats(pins.flatMap(([node, control]) => minus(at(node), at(nodes.length + Number(control)))), 3),
    'rods.lengths': indices(rods.map((rod) => rod.length)),
    'rods.nodes': indices(rods.flat()),
    'rods.twist_stiffness': same(rods.length, 0.02),
    'rods.twist_damping': same(rods.length, 1e-3),
    'rods.rest_twist': same(rods.length, 4),
    'skin.observed_point': indices(Array(count).fill(NONE)),
    'skin.weight_count': indices(surface.counts),
    'skin.weight_node': indices(surface.nodes),
    'skin.weight': floats(surface.weights),
    'skin.frame': indices(Array(3 * count).fill(NONE), 3),
    'skin.offset': floats(surface.counts.flatMap(() => [0, 0, -surface.drop]), 3),
  };
  return encode(tensors, {
    version: skin === undefined ? 3 : 6,
    environment: { gravity: [0, 0, -9.81], ground: ground ?? { normal: [0, 0, 1], offset_m: 0 } },
    timing: { fps: 30, substeps: 60 },
    control_velocity: velocity ?? 'true',
    drag: 1.5,
    contact: {
      ground_restitution: 0.3,
      ground_friction: 0.4,
      object_restitution: 0.2,
      object_friction: 0.3,
      collision_distance_m: 0.02,
      between_objects: true,
      within_object: false,
      ...contact,
    },
    provenance: {
      capture_digest: '', capture_name: '', settings: null, build: 'by hand', backend: '',
      source_to_world: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    },
    quality: { scores: [] },
  });
}

/** @typedef {{ dtype: string, width: number, values: Uint8Array | Float32Array | Uint32Array }} Tensor */

/**
 * @param {Record<string, Tensor>} tensors
 * @param {object} about
 */
function encode(tensors, about) {
  /** @type {Record<string, unknown>} */
  const header = { __metadata__: { 'bendtwin.twin': JSON.stringify(about) } };
  let end = 0;
  for (const [name, { dtype, width, values }] of Object.entries(tensors)) {
    const shape = width === 1 ? [values.length] : [values.length / width, width];
    header[name] = { dtype, shape, data_offsets: [end, (end += values.byteLength)] };
  }
  const text = JSON.stringify(header);
  const padded = Buffer.from(text.padEnd(8 * Math.ceil(text.length / 8)));
  const length = Buffer.alloc(8);
  length.writeBigUInt64LE(BigInt(padded.length));
  const data = Object.values(tensors).map(({ values }) => Buffer.from(values.buffer));
  return Buffer.concat([length, padded, ...data]);
}

/** @returns {Tensor} */
function floats(/** @type {number[]} */ values, width = 1) {
  return { dtype: 'F32', width, values: Float32Array.from(values) };
}

/** @returns {Tensor} */
function indices(/** @type {number[]} */ values, width = 1) {
  return { dtype: 'U32', width, values: Uint32Array.from(values) };
}

function minus(/** @type {number[]} */ a, /** @type {number[]} */ b) {
  return a.map((value, axis) => value - Number(b[axis]));
}

function angle(/** @type {number[]} */ u, /** @type {number[]} */ w) {
  const overlap = u.reduce((sum, value, axis) => sum + value * Number(w[axis]), 0);
  return Math.acos(Math.min(1, Math.max(-1, overlap / (Math.hypot(...u) * Math.hypot(...w)))));
}

/** Numbers from 0 to 1, the same in every run (a linear congruential generator). */
function randomly() {
  let state = 1;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}
