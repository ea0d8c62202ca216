import { Group, Mesh, MeshBasicMaterial, MeshLambertMaterial, SphereGeometry, TorusGeometry, Vector3 } from 'three';
import type { Layer } from '../stage';

/** A displayed hand or gripper. */
export interface ShownHand {
  readonly position: Vector3;
  readonly holds: boolean;
  readonly selected: boolean;
  readonly visible: boolean;
}

const COLOURS = { holds: 0xf08c00, open: 0x8a94a0 };

/** Hands and grippers as balls; the one that keys move has a ring. */
export class HandsLayer implements Layer {
  readonly object = new Group();
  readonly #ball: SphereGeometry;
  readonly #ring: TorusGeometry;
  readonly #holds = new MeshLambertMaterial({ color: COLOURS.holds });
  readonly #open = new MeshLambertMaterial({ color: COLOURS.open, transparent: true, opacity: 0.75 });
  readonly #ringMaterial = new MeshBasicMaterial({ color: 0x1c7ed6 });
  readonly #hands: { ball: Mesh; ring: Mesh }[] = [];

  constructor(radius: number) {
    this.#ball = new SphereGeometry(radius, 20, 14);
    this.#ring = new TorusGeometry(radius * 1.6, radius * 0.16, 8, 32);
  }

  /** Shows hands, towards a camera. */
  place(hands: readonly ShownHand[], camera: Vector3): void {
    while (this.#hands.length < hands.length) {
      const shown = { ball: new Mesh(this.#ball, this.#open), ring: new Mesh(this.#ring, this.#ringMaterial) };
      this.#hands.push(shown);
      this.object.add(shown.ball, shown.ring);
    }
    this.#hands.forEach(({ ball, ring }, g) => {
      const hand = hands[g];
      ball.visible = hand?.visible ?? false;
      ring.visible = ball.visible && (hand?.selected ?? false);
      if (hand === undefined) return;
      ball.position.copy(hand.position);
      ball.material = hand.holds ? this.#holds : this.#open;
      ring.position.copy(hand.position);
      ring.lookAt(camera);
    });
  }

  dispose(): void {
    for (const part of [this.#ball, this.#ring, this.#holds, this.#open, this.#ringMaterial]) part.dispose();
  }
}
