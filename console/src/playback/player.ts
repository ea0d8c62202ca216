import type { TwinShape } from '../view3d/shape';
import { placeSkin, pointCount } from '../view3d/skin';
import { Nearest } from '../view3d/surface/nearest';
import { rangeOf, type Range } from '../view3d/colour';
import type { Dots } from './camera/camera_view';
import type { Cameras } from './camera/cameras';
import type { ColourBy, Look } from './look';
import { visiblePoints, type Seen } from './extent';
import type { Motion } from './file/motion';
import type { Prediction } from './prediction';
import { COLOURS, coloursOf, type Scene } from './scene';

/** Least difference between the ends of the colours of errors [m]. */
const LEAST_RANGE_M = 1e-3;

/** Draws frames of a sequence: into space, and into the images of cameras. */
export class Player {
  /** The prediction with the shape of its twin, once it is here. */
  twin: { readonly prediction: Prediction; readonly shape: TwinShape } | null = null;
  #range: Range | null = null;

  constructor(
    private readonly motion: Motion,
    private readonly scene: Scene,
    /** Null without cameras. */
    private readonly cameras: Cameras | null,
    /** Red, green, blue of each point, shape [P, 3]; null if unknown. */
    private readonly colors: Uint8Array | null,
    private readonly look: Look,
  ) {}

  /** True if a frame can be drawn. */
  has(frame: number): boolean {
    return this.motion.frame(frame) !== null && (this.cameras?.has(frame) ?? true);
  }

  /** Loads what a frame needs. */
  async load(frame: number): Promise<void> {
    await Promise.all([this.motion.load(frame), this.cameras?.load(frame)]);
  }

  /** Draws the loaded part of a frame. */
  draw(frame: number): void {
    const { look, scene } = this;
    const here = this.motion.frame(frame);
    if (here === null) return;
    const nodes = this.twin?.prediction.nodes(frame) ?? null;
    const seen = visiblePoints(here);
    const by = this.#colourBy;
    const colours = this.#colours(seen, nodes, by);
    const shown = { points: seen.points, colours, controls: here.controls, nodes };
    scene.show(shown, look);
    const layers: Dots[] = [];
    // In their own colours they would be invisible on the image.
    const colour = by === 'own' ? css(COLOURS.observed) : colours;
    if (look.observed) layers.push({ points: seen.points, colour, radius: 1.25 });
    if (look.controls) layers.push({ points: here.controls, colour: css(COLOURS.controls), radius: 2.5 });
    if (look.prediction && nodes !== null && this.twin !== null) {
      const count = nodes.length / 3;
      const inner = this.twin.shape.springs;
      const lines = look.springs ? { lines: innerLines(inner, count) } : {};
      layers.push({ points: nodes, colour: css(COLOURS.predicted), radius: 1.25, ...lines });
    }
    this.cameras?.draw(frame, layers);
  }

  /** What the observed points are coloured by. */
  get #colourBy(): ColourBy {
    const { look, colors } = this;
    if (look.colour !== 'auto') return look.colour;
    const isOver = this.twin !== null && look.prediction && !look.beside;
    return colors === null || isOver ? 'plain' : 'own';
  }

  #colours(seen: Seen, nodes: Float32Array | null, by: ColourBy): Uint8Array {
    const { colors } = this;
    if (by === 'error' && nodes !== null && this.twin !== null) {
      const errors = distances(seen.points, nodes, this.twin.shape);
      const found = rangeOf(errors);
      // The range only grows, so that a colour means the same in all frames that were seen.
      this.#range = { low: 0, high: Math.max(found.high, this.#range?.high ?? 0, LEAST_RANGE_M) };
      this.scene.explain(this.#range);
      return coloursOf(errors, this.#range);
    }
    this.scene.explain(null);
    const bytes = new Uint8Array(seen.points.length);
    const plain = [(COLOURS.observed >> 16) & 255, (COLOURS.observed >> 8) & 255, COLOURS.observed & 255];
    seen.indices.forEach((index, i) => {
      bytes.set(by === 'own' && colors !== null ? colors.subarray(3 * index, 3 * index + 3) : plain, 3 * i);
    });
    return bytes;
  }
}

/** Distance of each point to the nearest one of a twin's skin [m], or to the nearest node. */
function distances(points: Float32Array, nodes: Float32Array, shape: TwinShape): Float32Array {
  let surface = nodes;
  if (pointCount(shape.skin) > 0 && nodes.length === shape.rest.length) {
    surface = new Float32Array(3 * pointCount(shape.skin));
    placeSkin(shape.skin, nodes, surface);
  }
  const nearest = new Nearest(surface, shape.spacing);
  return Float32Array.from({ length: points.length / 3 }, (_, i) => nearest.distance(points, i));
}

/** Springs between nodes, without those of control points. */
function innerLines(springs: Uint32Array, nodes: number): Uint32Array {
  const lines: number[] = [];
  for (let s = 0; s + 1 < springs.length; s += 2) {
    if (springs[s]! < nodes && springs[s + 1]! < nodes) lines.push(springs[s]!, springs[s + 1]!);
  }
  return Uint32Array.from(lines);
}

function css(colour: number): string {
  return `#${colour.toString(16).padStart(6, '0')}`;
}
