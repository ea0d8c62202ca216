/** Time that a picture of a twin takes: made up of as many nodes and points of skin as the address says. */
import type { Splats } from '../src/view3d/appearance';
import { Legend } from '../src/view3d/legend';
import type { TwinShape } from '../src/view3d/shape';
import { startsOf } from '../src/view3d/skin';
import { Stage } from '../src/view3d/stage';
import type { Surface } from '../src/view3d/surface/surface';
import { TwinView, type TwinLayer } from '../src/view3d/twin_view';

const query = new URLSearchParams(location.search);
const nodes = Number(query.get('nodes') ?? 10_000);
const points = Number(query.get('points') ?? 5_000);
const triangles = Number(query.get('triangles') ?? 0);
const splats = Number(query.get('splats') ?? 0);
const frames = Number(query.get('frames') ?? 300);
const WEIGHTS = 8;

/** A sheet of nodes with springs to their neighbours, and a skin of points that 8 nodes carry. */
function sheet(): TwinShape {
  const side = Math.ceil(Math.sqrt(nodes));
  const rest = Float32Array.from({ length: 3 * nodes }, (_, i) => {
    const node = Math.floor(i / 3);
    return [(node % side) / side, Math.floor(node / side) / side, 0.2][i % 3]!;
  });
  const pairs: number[] = [];
  for (let node = 0; node < nodes; node += 1) {
    for (const step of [1, 2, side, side + 1, side - 1, 2 * side]) {
      if (node + step < nodes) pairs.push(node, node + step);
    }
  }
  const springs = new Uint32Array(pairs);
  const near = (point: number, k: number): number => Math.min(Math.floor((point * nodes) / points) + k, nodes - 1);
  return {
    rest,
    controls: new Float32Array(0),
    hands: new Uint32Array(0),
    springs,
    restLengths: new Float32Array(springs.length / 2).fill(1 / side),
    springStiffness: new Float32Array(0),
    triplets: new Uint32Array(0),
    bendStiffness: new Float32Array(0),
    rods: [],
    skin: {
      starts: startsOf(new Uint32Array(points).fill(WEIGHTS)),
      nodes: Uint32Array.from({ length: WEIGHTS * points }, (_, k) => near(Math.floor(k / WEIGHTS), k % WEIGHTS)),
      weights: new Float32Array(WEIGHTS * points).fill(1 / WEIGHTS),
      frames: Uint32Array.from({ length: 3 * points }, (_, k) => near(Math.floor(k / 3), [0, 1, side][k % 3]!)),
      offsets: Float32Array.from({ length: 3 * points }, (_, k) => (k % 3 === 2 ? 0.002 : 0)),
    },
    surface: triangles === 0 ? null : surfaceOf(side),
    ground: { normal: [0, 0, 1], offset_m: 0 },
    gravity: [0, 0, -9.81],
    fps: 60,
    skinSd: new Float32Array(0),
    appearance: splats === 0 ? null : { skinColours: new Uint8Array(0), splats: splatsOf(side) },
    massKg: null,
    mass: nodes,
    spacing: 1 / side,
  };
}

/** A surface on the sheet, whose vertices 8 nodes carry. */
function surfaceOf(side: number): Surface {
  const edge = Math.ceil(Math.sqrt(triangles / 2)) + 1;
  const vertices = edge * edge;
  const near = (v: number, k: number): number => {
    const [x, y] = [(v % edge) / edge, Math.floor(v / edge) / edge];
    return Math.min(Math.floor(y * side) * side + Math.floor(x * side) + k, nodes - 1);
  };
  const corners: number[] = [];
  for (let v = 0; v + edge + 1 < vertices; v += 1) {
    if ((v + 1) % edge !== 0) corners.push(v, v + 1, v + edge + 1, v, v + edge + 1, v + edge);
  }
  return {
    carriers: {
      starts: startsOf(new Uint32Array(vertices).fill(WEIGHTS)),
      nodes: Uint32Array.from({ length: WEIGHTS * vertices }, (_, k) => near(Math.floor(k / WEIGHTS), k % WEIGHTS)),
      weights: new Float32Array(WEIGHTS * vertices).fill(1 / WEIGHTS),
      frames: Uint32Array.from({ length: 3 * vertices }, (_, k) => near(Math.floor(k / 3), [0, 1, side][k % 3]!)),
      offsets: Float32Array.from({ length: 3 * vertices }, (_, k) => (k % 3 === 2 ? 0.002 : 0)),
    },
    triangles: Uint32Array.from(corners),
    colours: Uint8Array.from({ length: 3 * vertices }, (_, i) => 128 + 100 * Math.sin(i / (50 + 40 * (i % 3)))),
    tubes: [],
  };
}

/** Splats that lie on the sheet, as flat as a surface's, in the colours of their places. */
function splatsOf(side: number): Splats {
  const each = (width: number, value: (g: number, k: number) => number): Float32Array =>
    Float32Array.from({ length: width * splats }, (_, i) => value(Math.floor(i / width), i % width));
  const near = (g: number, k: number): number => Math.min(Math.floor((g * nodes) / splats) + k, nodes - 1);
  return {
    carriers: {
      starts: startsOf(new Uint32Array(splats).fill(WEIGHTS)),
      nodes: Uint32Array.from({ length: WEIGHTS * splats }, (_, k) => near(Math.floor(k / WEIGHTS), k % WEIGHTS)),
      weights: new Float32Array(WEIGHTS * splats).fill(1 / WEIGHTS),
      frames: Uint32Array.from({ length: 3 * splats }, (_, k) => near(Math.floor(k / 3), [0, 1, side][k % 3]!)),
      offsets: each(3, (_, k) => (k === 2 ? 0.002 : 0)),
    },
    scales: each(3, (_, k) => (k === 2 ? 0.1 : 0.6) / Math.sqrt(splats)),
    rotations: each(4, (_, k) => (k === 3 ? 1 : 0)),
    opacities: each(1, () => 0.8),
    colours: each(3, (g, k) => 0.5 + 0.5 * Math.sin(g / (50 + 40 * k))),
  };
}

/** Moves all nodes in every frame; times [ms] on the CPU, and between pictures. */
function measure(): Promise<{ cpu: number[]; apart: number[] }> {
  const shape = sheet();
  const stage = new Stage('A sheet');
  document.body.append(stage.element);
  const view = new TwinView(stage, shape, new Legend());
  view.above(shape.ground);
  const drawn: TwinLayer[] = splats + triangles === 0 ? ['skin', 'nodes', 'springs', 'shadow'] : ['skin', 'appearance', 'shadow'];
  view.show(new Set(drawn));
  stage.lookAt(shape.rest);
  const moved = shape.rest.slice();
  const result = { cpu: [] as number[], apart: [] as number[] };
  let last = 0;
  let placed = 0;
  return new Promise((resolve) => {
    stage.beforeFrame((now) => {
      if (last > 0) {
        result.cpu.push(placed + stage.drawMs);
        result.apart.push(now - last);
      }
      last = now;
      const begun = performance.now();
      for (let n = 0; n < nodes; n += 1) moved[3 * n + 2] = 0.2 + 0.05 * Math.sin(now / 300 + 9 * moved[3 * n]!);
      view.place(moved, shape.controls);
      placed = performance.now() - begun;
      if (result.cpu.length < frames) return true;
      resolve(result);
      return false;
    });
  });
}

void measure().then((result) => {
  const pre = document.createElement('pre');
  const drawn = document.querySelector('.splat-count')?.textContent ?? '';
  pre.textContent = JSON.stringify({ ...result, drawn });
  document.body.append(pre);
});
