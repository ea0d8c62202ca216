import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshLambertMaterial, Vector3 } from 'three';
import type { Layer } from '../stage';

/** An arrow from a point, with its length [m]. */
export interface Arrow {
  readonly from: Vector3;
  readonly way: Vector3;
}

const UP = new Vector3(0, 1, 0);

/** Arrows, for forces. */
export class ArrowsLayer implements Layer {
  readonly object = new Group();
  readonly #shaft: CylinderGeometry;
  readonly #head: ConeGeometry;
  readonly #headLength: number;
  readonly #material = new MeshLambertMaterial({ color: 0xc2255c });
  readonly #arrows: { group: Group; shaft: Mesh; head: Mesh }[] = [];

  /** Arrows whose shafts are so thick [m]. */
  constructor(radius: number) {
    this.#shaft = new CylinderGeometry(radius, radius, 1, 10).translate(0, 0.5, 0);
    this.#headLength = radius * 6;
    this.#head = new ConeGeometry(radius * 2.6, this.#headLength, 14).translate(0, -this.#headLength / 2, 0);
  }

  /** Shows these arrows, and no others. */
  place(arrows: readonly Arrow[]): void {
    while (this.#arrows.length < arrows.length) {
      const [shaft, head] = [new Mesh(this.#shaft, this.#material), new Mesh(this.#head, this.#material)];
      const group = new Group().add(shaft, head);
      this.#arrows.push({ group, shaft, head });
      this.object.add(group);
    }
    this.#arrows.forEach(({ group, shaft, head }, index) => {
      const arrow = arrows[index];
      const length = arrow?.way.length() ?? 0;
      group.visible = length > 1e-4;
      if (arrow === undefined || !group.visible) return;
      group.position.copy(arrow.from);
      group.quaternion.setFromUnitVectors(UP, arrow.way.clone().divideScalar(length));
      const size = Math.min(1, length / this.#headLength);
      shaft.scale.set(size, Math.max(length - 0.9 * size * this.#headLength, 1e-4), size);
      head.scale.setScalar(size);
      head.position.y = length;
    });
  }

  dispose(): void {
    for (const part of [this.#shaft, this.#head, this.#material]) part.dispose();
  }
}
