import { Plane, Raycaster, Vector2, Vector3 } from 'three';
import type { Driver } from './driver';
import type { PlayScene } from '../scene';

/** Object under the mouse or a finger. */
export type Hit =
  | { readonly kind: 'hand'; readonly gripper: number }
  | { readonly kind: 'node'; readonly node: number }
  | { readonly kind: 'collider'; readonly collider: number }
  | { readonly kind: 'goal'; readonly node: number };

/** Distance within which a point counts as pointed at [pixels], for a mouse and for a finger. */
const REACH = { mouse: 26, touch: 44 };
/** Depth of one notch of the wheel, as a share of the distance to the camera. */
const WHEEL = 0.05;

/** Says what dragging does in the page now. */
export interface DragMode {
  /** True if nothing can be moved: dragging turns the view. */
  isWatching(): boolean;
  /** True if dragging a node sets a goal for it instead of grasping it. */
  setsGoal(): boolean;
  /** True if the grasp is kept when the button is released. */
  keepsHold(): boolean;
  goalSet(node: number): void;
  colliderMoved(collider: number, to: Vector3): void;
  selected(): void;
}

/** Something that is dragged. */
interface Drag {
  /** The pointer that drags. */
  readonly id: number;
  readonly hit: Hit;
  /** The gripper that goes along, or -1. */
  readonly gripper: number;
  /** Plane of dragging: across the camera's view. */
  readonly plane: Plane;
  /** From what is pointed at on the plane to what is dragged. */
  offset: Vector3;
  at: Vector2;
}

/** Dragging with a mouse or a finger; what does not begin at something moves the camera. */
export class PointerDrag {
  readonly #ray = new Raycaster();
  #drag: Drag | null = null;

  constructor(
    private readonly scene: PlayScene,
    private readonly driver: Driver,
    private readonly mode: DragMode,
  ) {
    const { canvas } = scene.stage;
    const options = { capture: true };
    canvas.addEventListener('pointerdown', this.#down, options);
    canvas.addEventListener('pointermove', this.#move, options);
    canvas.addEventListener('pointerup', this.#up, options);
    canvas.addEventListener('pointercancel', this.#up, options);
    canvas.addEventListener('wheel', this.#wheel, { capture: true, passive: false });
  }

  /** True while something is dragged. */
  get isDragging(): boolean {
    return this.#drag !== null;
  }

  readonly #down = (event: PointerEvent): void => {
    if (this.#drag !== null) return event.stopImmediatePropagation();
    if (event.button !== 0 || !event.isPrimary || this.mode.isWatching()) return;
    const at = this.#at(event);
    const hit = this.#hit(at, event.pointerType === 'touch' ? REACH.touch : REACH.mouse);
    if (hit === null) return;
    const gripper = this.#take(hit, event.timeStamp);
    if (gripper === null) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    const { canvas, camera } = this.scene.stage;
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    const from = this.#placeOf(hit);
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), from);
    this.#drag = { id: event.pointerId, hit, gripper, plane, offset: new Vector3(), at };
    this.#drag.offset = from.sub(this.#onPlane(at) ?? from);
    canvas.classList.add('is-dragging');
  };

  readonly #move = (event: PointerEvent): void => {
    const drag = this.#drag;
    if (drag === null) {
      if (event.buttons === 0 && !this.mode.isWatching()) this.#hover(event);
      return;
    }
    event.stopImmediatePropagation();
    if (event.pointerId !== drag.id) return;
    drag.at = this.#at(event);
    this.#follow(event.timeStamp);
  };

  readonly #up = (event: PointerEvent): void => {
    const drag = this.#drag;
    if (drag === null || event.pointerId !== drag.id) return;
    event.stopImmediatePropagation();
    this.#drag = null;
    this.scene.stage.canvas.classList.remove('is-dragging');
    this.driver.flush();
    if (drag.hit.kind === 'node' && drag.gripper >= 0 && !event.shiftKey && !this.mode.keepsHold()) {
      this.driver.release(drag.gripper, event.timeStamp);
    }
    if (drag.hit.kind === 'goal' || (drag.hit.kind === 'node' && drag.gripper < 0)) this.mode.goalSet(drag.hit.node);
    if (drag.hit.kind === 'collider') this.scene.selectedCollider = null;
    this.mode.selected();
  };

  /** While something is dragged the wheel moves it away and closer. */
  readonly #wheel = (event: WheelEvent): void => {
    const drag = this.#drag;
    if (drag === null) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    const { camera } = this.scene.stage;
    const place = this.#placeOf(drag.hit);
    const step = -Math.sign(event.deltaY) * WHEEL * camera.position.distanceTo(place);
    drag.plane.translate(camera.getWorldDirection(new Vector3()).multiplyScalar(step));
    this.#follow(event.timeStamp);
  };

  #follow(time: number): void {
    const drag = this.#drag;
    const to = drag === null ? null : this.#onPlane(drag.at);
    if (drag === null || to === null) return;
    to.add(drag.offset).clampScalar(-99, 99);
    const { hit } = drag;
    if (hit.kind === 'goal' || (hit.kind === 'node' && drag.gripper < 0)) {
      this.scene.goal.targets.set(hit.node, to);
      this.scene.stage.invalidate();
    } else if (hit.kind === 'collider') this.mode.colliderMoved(hit.collider, to);
    else this.driver.move(drag.gripper, to, time);
  }

  /** Begins to drag what was hit; returns the gripper, -1 for what needs none, null without a free one. */
  #take(hit: Hit, time: number): number | null {
    if (hit.kind === 'goal') return -1;
    if (hit.kind === 'collider') {
      this.scene.selectedCollider = hit.collider;
      return -1;
    }
    if (hit.kind === 'node' && this.mode.setsGoal()) return -1;
    const gripper = hit.kind === 'hand' ? hit.gripper : this.driver.free();
    if (gripper === null) return null;
    if (hit.kind === 'node') this.driver.grasp(gripper, hit.node, time);
    this.driver.selected = gripper;
    this.mode.selected();
    return gripper;
  }

  #placeOf(hit: Hit): Vector3 {
    if (hit.kind === 'hand') return this.scene.gripper(hit.gripper);
    if (hit.kind === 'node') return this.scene.node(hit.node);
    if (hit.kind === 'goal') return this.scene.goal.targets.get(hit.node)?.clone() ?? this.scene.node(hit.node);
    return new Vector3().fromArray(this.scene.motion.shown.colliders, 7 * hit.collider);
  }

  #hover(event: PointerEvent): void {
    const hit = this.#hit(this.#at(event), REACH.mouse);
    this.scene.stage.canvas.classList.toggle('can-drag', hit !== null);
  }

  /** The nearest of what is within reach; hands come before nodes, and what is solid before both if it is in front. */
  #hit(at: Vector2, reach: number): Hit | null {
    const { scene, driver } = this;
    let best: { hit: Hit; distance: number } | null = null;
    const offer = (hit: Hit, place: Vector3, bonus: number): void => {
      const seen = scene.stage.project(place);
      if (seen === null) return;
      const distance = Math.hypot(seen.x - at.x, seen.y - at.y) - bonus;
      if (distance < reach - bonus && (best === null || distance < best.distance)) best = { hit, distance };
    };
    for (const [node, place] of scene.goal.targets) offer({ kind: 'goal', node }, place, 14);
    for (const gripper of driver.usable) {
      if (gripper < driver.hands || driver.isHolding(gripper)) {
        offer({ kind: 'hand', gripper }, scene.gripper(gripper), 10);
        offer({ kind: 'hand', gripper }, scene.gripperMiddle(gripper), 0);
      }
    }
    const nodes = scene.motion.shown.positions.length / 3;
    for (let node = 0; node < nodes; node += 1) offer({ kind: 'node', node }, scene.node(node), 0);
    const found = best as { hit: Hit; distance: number } | null;
    return found?.hit ?? this.#colliderAt(at);
  }

  #colliderAt(at: Vector2): Hit | null {
    this.#aim(at);
    const [first] = this.#ray.intersectObjects([...this.scene.colliders.meshes]);
    const body = first?.object.parent;
    const collider = body == null ? -1 : this.scene.colliders.object.children.indexOf(body);
    return collider < 0 ? null : { kind: 'collider', collider };
  }

  #onPlane(at: Vector2): Vector3 | null {
    this.#aim(at);
    return this.#drag === null ? null : this.#ray.ray.intersectPlane(this.#drag.plane, new Vector3());
  }

  #aim(at: Vector2): void {
    const { canvas, camera } = this.scene.stage;
    const seen = new Vector2((2 * at.x) / canvas.clientWidth - 1, 1 - (2 * at.y) / canvas.clientHeight);
    this.#ray.setFromCamera(seen, camera);
  }

  #at(event: PointerEvent): Vector2 {
    const box = this.scene.stage.canvas.getBoundingClientRect();
    return new Vector2(event.clientX - box.left, event.clientY - box.top);
  }
}
