import {
  BoxGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  TorusGeometry,
  type Quaternion,
  type Vector3,
} from 'three';
import type { Layer } from '../stage';

/** A displayed hand or gripper. */
export interface ShownHand {
  /** Place between the tips of the fingers. */
  readonly position: Vector3;
  readonly turn: Quaternion;
  readonly holds: boolean;
  readonly selected: boolean;
  readonly visible: boolean;
}

/** Sizes of a gripper in radii: from the tips up to the palm, and from the middle to each finger. */
const PALM = 2.6;
const OPEN = 1.35;
const CLOSED = 0.7;
/** Share of the way to its place that a finger moves in a picture. */
const SPEED = 0.35;

interface Gripper {
  readonly group: Group;
  readonly fingers: readonly [Mesh, Mesh];
  readonly ring: Mesh;
  gap: number;
}

/** Hands with two fingers, which reach down along their own axis and close on what they hold. */
export class HandsLayer implements Layer {
  readonly object = new Group();
  readonly #finger: BoxGeometry;
  readonly #palm: BoxGeometry;
  readonly #wrist: CylinderGeometry;
  readonly #ring: TorusGeometry;
  readonly #holds = new MeshLambertMaterial({ color: 0xf08c00, emissive: 0x502f00 });
  readonly #open = new MeshLambertMaterial({ color: 0x9aa5b1, emissive: 0x22262a });
  readonly #metal = new MeshLambertMaterial({ color: 0x55606c, emissive: 0x14171a });
  readonly #selected = new MeshBasicMaterial({ color: 0x1c7ed6 });
  readonly #hands: Gripper[] = [];

  /** `radius` is that of what the fingers close on [m]. */
  constructor(private readonly radius: number) {
    const r = radius;
    this.#finger = new BoxGeometry(0.55 * r, 0.9 * r, 2.6 * r).translate(0, 0, 0.9 * r);
    this.#palm = new BoxGeometry(3.5 * r, 1.3 * r, 0.8 * r).translate(0, 0, PALM * r);
    this.#wrist = new CylinderGeometry(0.75 * r, 0.75 * r, 1.4 * r, 16).rotateX(Math.PI / 2).translate(0, 0, (PALM + 1.1) * r);
    this.#ring = new TorusGeometry(1.05 * r, 0.22 * r, 8, 28).translate(0, 0, (PALM + 1.2) * r);
  }

  /** Shows hands; true while fingers move. */
  place(hands: readonly ShownHand[]): boolean {
    while (this.#hands.length < hands.length) this.#hands.push(this.#make());
    let moves = false;
    this.#hands.forEach((gripper, g) => {
      const hand = hands[g];
      const { group, ring } = gripper;
      const appears = !group.visible;
      group.visible = hand?.visible ?? false;
      if (hand === undefined || !hand.visible) return;
      group.position.copy(hand.position);
      group.quaternion.copy(hand.turn);
      ring.visible = hand.selected;
      for (const finger of gripper.fingers) finger.material = hand.holds ? this.#holds : this.#open;
      moves = this.#close(gripper, hand.holds ? CLOSED : OPEN, appears) || moves;
    });
    return moves;
  }

  dispose(): void {
    const parts = [this.#finger, this.#palm, this.#wrist, this.#ring, this.#holds, this.#open, this.#metal, this.#selected];
    for (const part of parts) part.dispose();
  }

  /** Moves the fingers towards a distance from the middle, or puts them there. */
  #close(gripper: Gripper, to: number, immediately: boolean): boolean {
    const rest = to - gripper.gap;
    const isThere = immediately || Math.abs(rest) < 0.02;
    gripper.gap = isThere ? to : gripper.gap + SPEED * rest;
    const [left, right] = gripper.fingers;
    left.position.x = -gripper.gap * this.radius;
    right.position.x = gripper.gap * this.radius;
    return !isThere;
  }

  #make(): Gripper {
    const [left, right] = [new Mesh(this.#finger, this.#open), new Mesh(this.#finger, this.#open)];
    const [palm, wrist] = [new Mesh(this.#palm, this.#metal), new Mesh(this.#wrist, this.#metal)];
    const ring = new Mesh(this.#ring, this.#selected);
    const group = new Group().add(left, right, palm, wrist, ring);
    group.visible = false;
    this.object.add(group);
    return { group, fingers: [left, right], ring, gap: OPEN };
  }
}

/** Height of the middle of a gripper above the tips of its fingers, in radii. */
export const GRIPPER_MIDDLE = PALM;
