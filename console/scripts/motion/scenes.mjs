// Small twins with a motion of their control points each, which together have everything that a twin's motion depends
// on: springs, bending, pins, twist, the ground, contact of nodes and of the skin.

import { twinFile } from './file.mjs';

/** Frames of each motion. */
export const FRAMES = 30;

/** @typedef {[number, number, number]} Point */
/** @typedef {{ name: string, file: Buffer, path: Point[][] }} Scene A twin file, and its control points by frame. */

/** @type {Scene[]} */
export const SCENES = [dragged(), dropped(), folded(), twisted()];

/** A sheet whose edge is dragged over the ground, which its skin meets, by springs that know velocities. */
function dragged() {
  const { nodes, springs, triplets } = sheet(5, 4, 0.03, [0, 0, 0.03]);
  /** @type {Point[]} */
  const controls = [[-0.02, 0.02, 0.05], [-0.02, 0.07, 0.05]];
  for (const control of [20, 21]) for (let node = 0; node < 4; node += 1) springs.push([node, control]);
  const file = twinFile({
    nodes, controls, springs, triplets,
    contact: { skin: true },
    skin: { counts: [3, 1, 2], nodes: [0, 1, 4, 3, 19, 18], weights: [0.6, 0.3, 0.1, 1, 1.3, -0.3], drop: 0.008 },
  });
  return { name: 'dragged', file, path: moved(controls, (t) => [-0.25 * t, 0.05 * t, 0]) };
}

/** A sheet between two pinned edges, onto which another object falls. */
function dropped() {
  const { nodes, springs, triplets } = sheet(5, 4, 0.03, [0, 0, 0.2]);
  /** @type {Point[]} */
  const ball = [[0.055, 0.045, 0.26], [0.065, 0.045, 0.265], [0.05, 0.052, 0.268], [0.057, 0.038, 0.272]];
  ball.forEach((_, a) => ball.slice(0, a).forEach((__, b) => springs.push([20 + a, 20 + b])));
  /** @type {Point[]} */
  const controls = [[0, 0, 0.2], [0.12, 0, 0.2]];
  const pins = [0, 1, 2, 3].map((node) => [node, 0]).concat([16, 17, 18, 19].map((node) => [node, 1]));
  const objects = nodes.map(() => 0).concat(ball.map(() => 7));
  const file = twinFile({ nodes: nodes.concat(ball), controls, springs, triplets, pins, objects });
  return { name: 'dropped', file, path: moved(controls, (t) => [0, 0.02 * Math.sin(3 * t), 0.04 * Math.sin(3 * t)]) };
}

/** A strip that is folded onto itself above a leaning ground, by control points that count as standing still. */
function folded() {
  const { nodes, springs, triplets } = sheet(9, 2, 0.025, [0, 0, 0.15]);
  /** @type {Point[]} */
  const controls = [[0, 0.0125, 0.15], [0.2, 0.0125, 0.15]];
  const pins = [[0, 0], [1, 0], [16, 1], [17, 1]];
  const contact = { within_object: true, collision_distance_m: 0.015 };
  const ground = { normal: [0, Math.sin(0.2), Math.cos(0.2)], offset_m: 0.12 };
  const file = twinFile({ nodes, controls, springs, triplets, pins, contact, ground, velocity: 'ignored' });
  const path = moved(controls, (t, c) => (c === 0 ? [0, 0, 0] : [-0.2 * t, 0, 0.012 * t + 0.06 * Math.sin(Math.PI * t)]));
  return { name: 'folded', file, path };
}

/** A cable between two clamps with a branch, whose rods have torques. */
function twisted() {
  /** @type {Point[]} */
  const nodes = Array.from({ length: 12 }, (_, k) => {
    const s = k / 11;
    return [0.25 * s, 0.05 * Math.sin(6 * s), 0.3 + 0.02 * Math.cos(9 * s)];
  });
  const [x, y, z] = /** @type {Point} */ (nodes[5]);
  nodes.push([x, y + 0.02, z + 0.01], [x + 0.01, y + 0.04, z + 0.01]);
  const chain = nodes.slice(1, 12).map((_, k) => [k, k + 1]).concat([[5, 12], [12, 13]]);
  const triplets = nodes.slice(2, 12).map((_, k) => [k, k + 1, k + 2]).concat([[4, 5, 12], [5, 12, 13]]);
  const controls = [nodes[0], nodes[11]].map((point) => /** @type {Point} */ ([.../** @type {Point} */ (point)]));
  const file = twinFile({
    nodes, controls, springs: chain, triplets,
    pins: [[0, 0], [1, 0], [10, 1], [11, 1]],
    rods: [[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11], [0, 1, 2, 3, 4, 5, 12]],
  });
  return { name: 'twisted', file, path: moved(controls, (t, c) => (c === 0 ? [0, 0, 0] : [-0.1 * t, 0.05 * t, 0.02 * t])) };
}

/**
 * Points of a slightly uneven sheet, springs between near ones, and the triplets of its rows and columns.
 * @param {number} rows
 * @param {number} columns
 * @param {number} spacing
 * @param {Point} at
 */
function sheet(rows, columns, spacing, at) {
  /** @type {Point[]} */
  const nodes = Array.from({ length: rows * columns }, (_, n) => {
    const [r, c] = [Math.floor(n / columns), n % columns];
    return [at[0] + spacing * r, at[1] + spacing * c, at[2] + 0.004 * Math.sin(2 * r + 3 * c)];
  });
  /** @type {number[][]} */
  const springs = [];
  nodes.forEach((p, a) => nodes.slice(0, a).forEach((q, b) => {
    if (Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]) < 1.6 * spacing) springs.push([a, b]);
  }));
  const along = nodes.map((_, a) => [a, a + 1, a + 2]).filter(([a]) => Number(a) % columns < columns - 2);
  const across = nodes.slice(2 * columns).map((_, a) => [a, a + columns, a + 2 * columns]);
  return { nodes, springs, triplets: along.concat(across) };
}

/**
 * Positions of control points by frame, moved from rest.
 * @param {Point[]} controls
 * @param {(t: number, control: number) => Point} by At a share of the time from 0 to 1.
 */
function moved(controls, by) {
  return Array.from({ length: FRAMES + 1 }, (_, frame) =>
    controls.map((point, c) => {
      const step = by(frame / FRAMES, c);
      return /** @type {Point} */ (point.map((value, axis) => value + Number(step[axis])));
    }),
  );
}
