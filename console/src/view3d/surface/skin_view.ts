import { SEQUENTIAL, rangeOf } from '../colour';
import { PointsLayer } from '../layers/points';
import { SurfaceLayer } from '../layers/surface';
import type { TwinShape } from '../shape';
import { placeSkin, pointCount } from '../skin';
import type { Stage } from '../stage';
import type { Caster } from './footprint';
import { SurfaceMesh } from './mesh';
import { Nearest } from './nearest';

/** Colour of a skin whose colours are unknown. */
const PLAIN = 0x4a90c8;

/** The skin of a twin: a surface, or the points of the skin where the twin has none. */
export class SkinView {
  readonly #surface: SurfaceLayer | null;
  readonly #points: PointsLayer | null;
  /** Skin point nearest to each vertex at rest; made when it is first needed. */
  #nearest: Int32Array | null = null;

  constructor(
    stage: Stage,
    private readonly shape: TwinShape,
  ) {
    const { surface, skin, spacing, rest } = shape;
    const points = Math.max(pointCount(skin), 1);
    // About as large as the room that a point has on the surface.
    const room = spacing * Math.min(1, Math.sqrt(rest.length / 3 / points));
    this.#surface = surface === null ? null : stage.add(new SurfaceLayer(surface, PLAIN));
    this.#points = surface !== null ? null
      : stage.add(new PointsLayer(new Float32Array(3 * points), { size: 1.1 * room, colour: PLAIN }));
  }

  get isVisible(): boolean {
    return this.#layer.object.visible;
  }

  set isVisible(is: boolean) {
    this.#layer.object.visible = is;
  }

  /** What casts its shadow; null if it is seen as points. */
  get caster(): Caster | null {
    return this.#surface === null ? null : { ...this.#surface.mesh, radius: 0 };
  }

  /** Moves it with nodes [m], shape [N, 3]. */
  place(nodes: Float32Array): void {
    this.#surface?.place(nodes);
    if (this.#points === null) return;
    placeSkin(this.shape.skin, nodes, this.#points.positions);
    this.#points.moved(pointCount(this.shape.skin));
  }

  /** Colours it by what the recordings leave open, in its own colours, or in one. */
  colour(by: 'plain' | 'own' | 'uncertainty'): void {
    const { skinSd } = this.shape;
    if (by === 'uncertainty') {
      const values = this.#surface === null ? skinSd : this.#ofNearest(skinSd, 1, (length) => new Float32Array(length));
      return this.#layer.colourBy(values, rangeOf(skinSd), SEQUENTIAL);
    }
    const colours = by === 'own' ? this.#ownColours() : null;
    if (colours === null) this.#layer.plain();
    else this.#layer.tint(colours);
  }

  /** Marks where something exceeds a limit, by values of nodes from 0 to 1, shape [N]; null for nothing. */
  warn(values: Float32Array | null): void {
    this.#surface?.warn(values);
  }

  get #layer(): SurfaceLayer | PointsLayer {
    return (this.#surface ?? this.#points)!;
  }

  /** Colours of vertices, or of points; null if they are not known. Tubes have those of the skin points near them. */
  #ownColours(): Uint8Array | null {
    const { appearance, skin, surface } = this.shape;
    const known = appearance?.skinColours ?? new Uint8Array(0);
    const ofSkin = known.length > 0 && known.length === 3 * pointCount(skin) ? known : null;
    if (surface === null) return ofSkin;
    if (surface.colours.length > 0 && surface.tubes.length === 0) return surface.colours;
    return ofSkin === null ? null : this.#ofNearest(ofSkin, 3, (length) => new Uint8Array(length));
  }

  /** Values of the skin points that are nearest to vertices, `width` numbers each. */
  #ofNearest<A extends Float32Array | Uint8Array>(values: A, width: number, make: (length: number) => A): A {
    this.#nearest ??= this.#nearestPoints();
    const out = make(width * this.#nearest.length);
    this.#nearest.forEach((point, v) => {
      for (let i = 0; i < width; i += 1) out[width * v + i] = values[width * point + i] ?? 0;
    });
    return out;
  }

  #nearestPoints(): Int32Array {
    const { skin, surface, rest, spacing } = this.shape;
    const points = new Float32Array(3 * pointCount(skin));
    placeSkin(skin, rest, points);
    const mesh = new SurfaceMesh(surface!);
    mesh.place(rest);
    const nearest = new Nearest(points, spacing);
    return Int32Array.from({ length: mesh.positions.length / 3 }, (_, v) => nearest.index(mesh.positions, v) ?? 0);
  }
}
