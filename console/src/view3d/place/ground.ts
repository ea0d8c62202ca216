import { Vector3 } from 'three';
import { h } from '../../ui/dom';
import { GroundLayer } from '../layers/ground';
import type { Plane } from '../shape';
import type { Stage } from '../stage';

/** The ground below an object, with a scale in text. */
export class Ground {
  readonly #layer: GroundLayer;
  readonly #label = h('span', { class: 'ground-scale' }, '10 cm');
  readonly #middle: Vector3;
  readonly #reach: number;
  #plane: Plane | null = null;
  #isShown = true;

  /** `rest` are the points of the object at rest [m], shape [M, 3]. */
  constructor(
    private readonly stage: Stage,
    rest: Float32Array,
  ) {
    this.#layer = stage.add(new GroundLayer());
    this.#middle = middleOf(rest);
    const foremost = rest.reduce((least, y, i) => (i % 3 === 1 && y < least ? y : least), this.#middle.y);
    this.#reach = this.#middle.y - foremost + 0.04;
    stage.overlay.append(this.#label);
    stage.beforeFrame(() => {
      this.#write();
      return false;
    });
  }

  /** Lies in a plane; hidden without one. */
  place(plane: Plane | null): void {
    this.#plane = plane;
    this.#layer.place(plane, this.#middle, this.#reach);
    this.isShown = this.#isShown;
  }

  get isShown(): boolean {
    return this.#isShown;
  }

  set isShown(is: boolean) {
    this.#isShown = is;
    this.#layer.object.visible = is && this.#plane !== null;
    this.stage.invalidate();
  }

  #write(): void {
    const at = this.#layer.object.visible ? this.stage.project(this.#layer.scaleAt) : null;
    this.#label.hidden = at === null;
    if (at !== null) this.#label.style.transform = `translate(${at.x.toFixed(1)}px, ${at.y.toFixed(1)}px)`;
  }
}

/** Mean of the points whose place is known, shape [M, 3]. */
export function middleOf(points: Float32Array): Vector3 {
  const sum = new Vector3();
  let count = 0;
  for (let i = 0; i + 2 < points.length; i += 3) {
    if (!Number.isFinite(points[i]!)) continue;
    sum.add(new Vector3(points[i], points[i + 1], points[i + 2]));
    count += 1;
  }
  return sum.divideScalar(Math.max(count, 1));
}
