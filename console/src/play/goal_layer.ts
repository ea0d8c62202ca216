import {
  BufferAttribute,
  BufferGeometry,
  Group,
  Line,
  LineBasicMaterial,
  Mesh,
  MeshLambertMaterial,
  SphereGeometry,
  Vector3,
} from 'three';
import type { Layer } from '../view3d/stage';
import type { GoalTarget } from './protocol/messages';

/** Goals of nodes: a ball for each target, and a line from its node. */
export class GoalLayer implements Layer {
  readonly object = new Group();
  /** Targets by node [m]. */
  readonly targets = new Map<number, Vector3>();
  readonly #ball: SphereGeometry;
  readonly #material = new MeshLambertMaterial({ color: 0x7048e8, transparent: true, opacity: 0.7 });
  readonly #lineMaterial = new LineBasicMaterial({ color: 0x7048e8 });
  readonly #shown: { ball: Mesh; line: Line }[] = [];

  constructor(radius: number) {
    this.#ball = new SphereGeometry(radius, 20, 14);
  }

  /** The targets as messages have them. */
  get list(): GoalTarget[] {
    return [...this.targets].map(([node, place]) => ({ node, position: place.toArray() }));
  }

  /** Draws lines from where nodes are [m], shape [N, 3]. */
  place(nodes: Float32Array): void {
    while (this.#shown.length < this.targets.size) {
      const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(6), 3));
      const shown = { ball: new Mesh(this.#ball, this.#material), line: new Line(geometry, this.#lineMaterial) };
      shown.line.frustumCulled = false;
      this.#shown.push(shown);
      this.object.add(shown.ball, shown.line);
    }
    const targets = [...this.targets];
    this.#shown.forEach(({ ball, line }, index) => {
      const target = targets[index];
      ball.visible = line.visible = target !== undefined;
      if (target === undefined) return;
      const [node, place] = target;
      ball.position.copy(place);
      const ends = line.geometry.getAttribute('position') as BufferAttribute;
      ends.set([...nodes.subarray(3 * node, 3 * node + 3), ...place.toArray()]);
      ends.needsUpdate = true;
    });
  }

  dispose(): void {
    for (const { line } of this.#shown) line.geometry.dispose();
    for (const part of [this.#ball, this.#material, this.#lineMaterial]) part.dispose();
  }
}
