import { DIVERGING, SEQUENTIAL, rangeOf, type Range } from './colour';
import { Endpoints } from './endpoints';
import { LinesLayer } from './layers/lines';
import { PointsLayer } from './layers/points';
import { ShadowLayer } from './layers/shadow';
import { SplatsLayer } from './layers/splats';
import type { Legend } from './legend';
import { sizeOf, type Plane, type TwinShape } from './shape';
import { pointCount } from './skin';
import { SplatBudget } from './splats/budget';
import { SplatCount } from './splats/count';
import type { Stage } from './stage';
import { SkinView } from './surface/skin_view';

/**
 * Layers of a twin that can be switched on and off; `skin` is its surface, or its points where it has none, and
 * `appearance` says that it is seen in its own colours.
 */
export type TwinLayer = 'skin' | 'appearance' | 'nodes' | 'springs' | 'triplets' | 'rods' | 'controls' | 'shadow';

/** Quantities that a twin can be coloured by. */
export type ColourBy = 'none' | 'stiffness' | 'strain' | 'uncertainty';

const COLOURS = {
  nodes: 0x0b7285,
  springs: 0x6b7783,
  triplets: 0x9c36b5,
  rods: 0x5f3dc4,
  controls: 0xf08c00,
};
const NO_FACES = new Uint32Array(0);
/** Strain at both ends of the colours. */
const STRAINS: Range = { low: -0.1, high: 0.1 };

/** A twin on a stage: all of its layers, moved together by its nodes. */
export class TwinView {
  readonly #stage: Stage;
  readonly #shape: TwinShape;
  readonly #legend: Legend;
  readonly #endpoints: Endpoints;
  readonly #skin: SkinView;
  readonly #nodes: PointsLayer;
  readonly #controls: PointsLayer;
  readonly #shadow: ShadowLayer;
  readonly #splats: SplatsLayer | null = null;
  readonly #splatCount = new SplatCount();
  #plane: Plane | null = null;
  #hasShadow = false;
  #isUncertain = false;
  #isOwn = false;
  readonly #lines: Record<'springs' | 'triplets' | 'rods', LinesLayer>;

  constructor(stage: Stage, shape: TwinShape, legend: Legend) {
    this.#stage = stage;
    this.#shape = shape;
    this.#legend = legend;
    const [nodes, controls] = [shape.rest.length / 3, shape.controls.length / 3];
    this.#endpoints = new Endpoints(nodes, controls);
    this.#skin = new SkinView(stage, shape);
    this.#nodes = stage.add(
      new PointsLayer(new Float32Array(3 * nodes), { size: 0.45 * shape.spacing, colour: COLOURS.nodes }),
    );
    this.#controls = stage.add(
      new PointsLayer(new Float32Array(3 * controls), { size: 0.35 * shape.spacing, colour: COLOURS.controls }),
    );
    this.#shadow = stage.add(new ShadowLayer(sizeOf(shape.rest)));
    this.#lines = {
      springs: stage.add(this.#springs()),
      triplets: stage.add(this.#triplets()),
      rods: stage.add(this.#rods()),
    };
    const splats = shape.appearance?.splats ?? null;
    if (splats !== null) this.#splats = this.#addSplats(new SplatsLayer(splats, shape.rest, shape.springs));
    this.show(new Set(['skin', 'appearance', 'shadow']));
    this.place(shape.rest, shape.controls);
  }

  /** Layers that have something to show. */
  get layers(): readonly TwinLayer[] {
    const { skin, surface, triplets, rods, controls } = this.#shape;
    const empty: Partial<Record<TwinLayer, boolean>> = {
      skin: pointCount(skin) === 0 && surface === null && this.#splats === null,
      appearance: !hasColours(this.#shape),
      triplets: triplets.length === 0,
      rods: rods.length === 0,
      controls: controls.length === 0,
    };
    const all: TwinLayer[] = ['skin', 'appearance', 'nodes', 'springs', 'triplets', 'rods', 'controls', 'shadow'];
    return all.filter((layer) => empty[layer] !== true);
  }

  /** Shows these layers and no others. */
  show(layers: ReadonlySet<TwinLayer>): void {
    const objects = {
      nodes: this.#nodes, controls: this.#controls, shadow: this.#shadow, ...this.#lines,
    };
    for (const [name, layer] of Object.entries(objects)) layer.object.visible = layers.has(name as TwinLayer);
    this.#showSurface(layers.has('skin'), layers.has('appearance'));
    this.#hasShadow = layers.has('shadow');
    this.#shadow.object.visible = this.#hasShadow && this.#plane !== null;
    // The skin is placed only while it is seen.
    this.#placeSurface();
    this.#castShadow();
    this.#stage.invalidate();
  }

  /** Places nodes [N, 3] and control points [C, 3], of which those that hold nothing carry no springs. */
  place(nodes: Float32Array, controls: Float32Array, holds: (control: number) => boolean = () => true): void {
    this.#nodes.positions.set(nodes);
    this.#nodes.moved();
    this.#placeSurface();
    this.#castShadow();
    this.#controls.positions.set(controls);
    this.#controls.moved();
    this.#endpoints.place(nodes, controls, holds);
    this.#stage.invalidate();
  }

  /** Lies above a ground. */
  above(plane: Plane | null): void {
    this.#plane = plane;
    this.#shadow.place(plane);
    this.#shadow.object.visible = this.#hasShadow && plane !== null;
    this.#castShadow();
  }

  /** Marks where the skin exceeds a limit, by values of nodes from 0 to 1, shape [N]; true if marks are seen. */
  warn(values: Float32Array | null): boolean {
    this.#skin.warn(values);
    return values !== null && this.#skin.isVisible && this.#skin.caster !== null;
  }

  /** Colours springs and triplets, or the skin, and says what the colours mean. */
  colourBy(quantity: ColourBy): void {
    const { springs, triplets } = this.#lines;
    const { springStiffness, bendStiffness, skinSd, massKg } = this.#shape;
    springs.plain();
    triplets.plain();
    this.#legend.hide();
    this.#isUncertain = quantity === 'uncertainty' && skinSd.length > 0;
    this.#colourSkin();
    if (this.#isUncertain) {
      const { low, high } = rangeOf(skinSd);
      this.#legend.show('What the recordings leave open', 'mm', { low: 1e3 * low, high: 1e3 * high }, SEQUENTIAL);
    }
    if (quantity === 'strain') {
      springs.colourByStrain(STRAINS, DIVERGING);
      this.#legend.show('Strain of springs, compressed to stretched', '', STRAINS, DIVERGING);
    } else if (quantity === 'stiffness' && springStiffness.length > 0) {
      const range = rangeOf(springStiffness);
      springs.colourBy(springStiffness, range, SEQUENTIAL);
      if (bendStiffness.length > 0) triplets.colourBy(twice(bendStiffness), rangeOf(bendStiffness), SEQUENTIAL);
      const unit = massKg === null ? 'N per unit strain and mass' : 'N per unit strain';
      this.#legend.show('Stiffness of springs', unit, range, SEQUENTIAL);
    }
    this.#stage.invalidate();
  }

  /** Frees what the stage does not. */
  dispose(): void {
    this.#endpoints.dispose();
  }

  /** Orders splats before each picture, draws as many as the machine is able to, and says how many. */
  #addSplats(layer: SplatsLayer): SplatsLayer {
    const stage = this.#stage;
    const budget = new SplatBudget(layer.count);
    stage.overlay.append(this.#splatCount.element);
    stage.beforeFrame((now) => {
      if (!layer.object.visible) return false;
      layer.drawn = budget.next(now);
      layer.sort(stage.camera);
      this.#splatCount.show(layer.drawn, layer.count);
      return false;
    });
    return stage.add(layer);
  }

  /** Shows the skin in one colour, or in its own colours: as splats where there are some. */
  #showSurface(isShown: boolean, isOwn: boolean): void {
    this.#isOwn = isOwn;
    const asSplats = isShown && isOwn && this.#splats !== null;
    this.#skin.isVisible = isShown && !asSplats;
    this.#colourSkin();
    if (this.#splats === null) return;
    this.#splats.object.visible = asSplats;
    if (!asSplats) this.#splatCount.hide();
  }

  #colourSkin(): void {
    this.#skin.colour(this.#isUncertain ? 'uncertainty' : this.#isOwn ? 'own' : 'plain');
  }

  #placeSurface(): void {
    if (this.#splats?.object.visible === true) this.#splats.place(this.#nodes.positions);
    if (this.#skin.isVisible) this.#skin.place(this.#nodes.positions);
  }

  /** Casts the shadow of the surface, or of the nodes where no surface is seen. */
  #castShadow(): void {
    if (!this.#shadow.object.visible) return;
    const ofSkin = this.#skin.isVisible ? this.#skin.caster : null;
    const positions = this.#nodes.positions;
    this.#shadow.cast(ofSkin ?? { positions, faces: NO_FACES, radius: 0.65 * this.#shape.spacing });
  }

  #springs(): LinesLayer {
    const { springs: ends, restLengths } = this.#shape;
    return new LinesLayer(this.#endpoints, { ends, from: 0, to: 1, restLengths }, COLOURS.springs, 0.55);
  }

  /** Each as two short lines from its centre towards its ends. */
  #triplets(): LinesLayer {
    const { triplets } = this.#shape;
    const ends = new Uint32Array((4 * triplets.length) / 3);
    for (let t = 0; t < triplets.length / 3; t += 1) {
      const [i, j, k] = triplets.subarray(3 * t, 3 * t + 3) as unknown as [number, number, number];
      ends.set([j, i, j, k], 4 * t);
    }
    return new LinesLayer(this.#endpoints, { ends, from: 0, to: 0.45 }, COLOURS.triplets, 0.8);
  }

  #rods(): LinesLayer {
    const pairs = this.#shape.rods.flatMap((rod) => Array.from(rod.subarray(1), (node, i) => [rod[i]!, node]));
    return new LinesLayer(this.#endpoints, { ends: new Uint32Array(pairs.flat()), from: 0, to: 1 }, COLOURS.rods, 1);
  }
}

/** True if the colours of a twin are known. */
export function hasColours({ appearance, surface }: Pick<TwinShape, 'appearance' | 'surface'>): boolean {
  return appearance !== null || (surface?.colours.length ?? 0) > 0;
}

/** A value for each of the two lines of a triplet. */
function twice(values: Float32Array): Float32Array {
  return Float32Array.from({ length: 2 * values.length }, (_, line) => values[line >> 1]!);
}
