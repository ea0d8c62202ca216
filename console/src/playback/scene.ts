import { Vector3 } from 'three';
import { SEQUENTIAL, colourAt, shareOf, type Range } from '../view3d/colour';
import { PointsLayer } from '../view3d/layers/points';
import { Legend } from '../view3d/legend';
import { Ground } from '../view3d/place/ground';
import type { TwinShape } from '../view3d/shape';
import { Stage } from '../view3d/stage';
import { TwinView, type TwinLayer } from '../view3d/twin_view';
import type { SequenceHead } from './file/head';
import { joined, near, type Extent } from './extent';
import { framing } from './framing';

/** Colours of observed points without own ones, of control points and of predicted nodes. */
export const COLOURS = { observed: 0x2f6fd0, controls: 0xf08c00, predicted: 0x0ca678 };

/** Size of observed points over a prediction, as a share of their usual one. */
const OVER = 0.45;

/** Observed points of a frame that are shown, with their colours. */
export interface Shown {
  /** [m], shape [M, 3] */
  readonly points: Float32Array;
  /** Red, green, blue, shape [M, 3]. */
  readonly colours: Uint8Array;
  readonly controls: Float32Array;
  /** Predicted nodes [m], shape [N, 3]. */
  readonly nodes: Float32Array | null;
}

/** The points of a sequence in three dimensions, with a prediction over them or beside them. */
export class Scene {
  readonly stage: Stage;
  readonly legend = new Legend();
  readonly #observed: PointsLayer;
  /** Diameter of observed points [m]. */
  readonly #size: number;
  readonly #controls: PointsLayer;
  readonly #resize: ResizeObserver;
  #twin: TwinView | null = null;
  #shape: TwinShape | null = null;
  /** Way from the observed points to the prediction that is shown beside them [m]. */
  #beside = new Vector3();
  /** Where all points are over all frames [m], shape [K, 3]. */
  #path: Float32Array;
  /** The view that frames everything, until a person chooses another one. */
  #framed = '';

  constructor(
    private readonly sequence: SequenceHead,
    private readonly extent: Extent,
    label: string,
  ) {
    this.#path = extent.path;
    this.stage = new Stage(label);
    this.stage.overlay.append(this.legend.element);
    const { point_count: points, control_count: controls } = sequence.motion;
    const { first } = extent;
    const whole = extentOf(first);
    // A few points, as of a cable, must not hide it.
    const size = (this.#size = Math.max(Math.min((0.65 * whole) / Math.sqrt(Math.max(points, 1)), 0.02 * whole), 0.002));
    this.#observed = this.stage.add(
      new PointsLayer(new Float32Array(3 * Math.max(points, 1)), { size, colour: COLOURS.observed }),
    );
    this.#controls = this.stage.add(
      new PointsLayer(new Float32Array(3 * Math.max(controls, 1)), { size: 1.2 * size, colour: COLOURS.controls }),
    );
    new Ground(this.stage, first).place(sequence.ground);
    this.#lookAtAll();
    this.#resize = new ResizeObserver(() => {
      if (this.view === null) this.#lookAtAll();
    });
    this.#resize.observe(this.stage.element);
  }

  /** The view that a person has chosen, for an address; null while everything is framed. */
  get view(): string | null {
    return this.stage.view === this.#framed ? null : this.stage.view;
  }

  /** Shows the prediction of a twin from now on; `nodes` [m], shape [K, 3], are where it comes to. */
  setTwin(shape: TwinShape, nodes: Float32Array): void {
    const { view } = this;
    this.#shape = shape;
    this.#twin = new TwinView(this.stage, shape, this.legend);
    this.#twin.above(this.sequence.ground);
    this.#path = joined([this.extent.path, near(nodes, this.extent.path)]);
    if (view === null) this.#lookAtAll();
    else this.stage.setView(view);
  }

  /** Layers of the twin that have something to show. */
  get layers(): readonly TwinLayer[] {
    return this.#twin?.layers ?? [];
  }

  /** Layers of the twin that are seen, and whether it stands beside the observed points. */
  showTwin(layers: ReadonlySet<TwinLayer>, isBeside: boolean): void {
    this.#twin?.show(layers);
    // The prediction is to be seen between the points.
    const isOver = this.#twin !== null && layers.size > 0 && !isBeside;
    this.#observed.size = this.#size * (isOver ? OVER : 1);
    const way = isBeside ? 1.5 * extentOf(this.extent.first) : 0;
    if (this.#beside.x === way) return;
    this.#beside.set(way, 0, 0);
    this.#lookAtAll();
  }

  /** Frames the paths of all points, and the place beside them if the prediction stands there. */
  #lookAtAll(): void {
    const path = this.#path;
    const all = this.#beside.x === 0 ? path : joined([path, moved(path, this.#beside)]);
    const { fov, aspect } = this.stage.camera;
    const found = framing(all, { degrees: fov, aspect });
    if (found === null) return;
    this.stage.setView([...found.position, ...found.target].join(','));
    this.#framed = this.stage.view;
  }

  /** Legend of colours that mean a number. */
  explain(range: Range | null): void {
    if (range === null) this.legend.hide();
    else this.legend.show('Distance to the prediction', 'mm', scaled(range), SEQUENTIAL);
  }

  /** Shows a frame. */
  show({ points, colours, controls, nodes }: Shown, visible: { observed: boolean; controls: boolean }): void {
    place(this.#observed, points, visible.observed);
    this.#observed.tint(padded(colours, this.#observed.positions.length));
    place(this.#controls, controls, visible.controls);
    if (this.#twin !== null && this.#shape !== null && nodes !== null && nodes.length === this.#shape.rest.length) {
      // Control points of another recording are others than the twin's own, which carry no springs here.
      this.#twin.place(moved(nodes, this.#beside), this.#shape.controls, () => false);
    }
    this.stage.invalidate();
  }

  dispose(): void {
    this.#resize.disconnect();
    this.#twin?.dispose();
    this.stage.dispose();
  }
}

/** Colours of values, red, green and blue as bytes; grey where there is no value. */
export function coloursOf(values: Float32Array, range: Range): Uint8Array {
  const bytes = new Uint8Array(3 * values.length).fill(128);
  values.forEach((value, i) => {
    if (Number.isNaN(value)) return;
    const colour = colourAt(SEQUENTIAL, shareOf(range, value));
    bytes.set(colour.map((part) => Math.round(255 * part)), 3 * i);
  });
  return bytes;
}

function place(layer: PointsLayer, points: Float32Array, isVisible: boolean): void {
  layer.object.visible = isVisible;
  layer.positions.set(points);
  layer.moved(points.length / 3);
}

function padded(bytes: Uint8Array, length: number): Uint8Array {
  const all = new Uint8Array(length);
  all.set(bytes);
  return all;
}

function moved(points: Float32Array, by: Vector3): Float32Array {
  const way = by.toArray();
  return points.map((x, i) => x + way[i % 3]!);
}

function scaled({ low, high }: Range): Range {
  return { low: 1000 * low, high: 1000 * high };
}

/** Largest extent of points along any axis [m]. */
function extentOf(points: Float32Array): number {
  const spans = [0, 1, 2].map((axis) => {
    const values = points.filter((x, i) => i % 3 === axis && Number.isFinite(x));
    const high = values.reduce((most, x) => Math.max(most, x), -Infinity);
    return values.length === 0 ? 0 : high - values.reduce((least, x) => Math.min(least, x), Infinity);
  });
  return Math.max(...spans, 0.05);
}
