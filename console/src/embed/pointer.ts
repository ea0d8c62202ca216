import { Plane, Raycaster, Vector2, Vector3 } from 'three';
import type { Stage } from '../view3d/stage';
import type { LiveTwin } from './live_twin';

/** Distance within which a node counts as pointed at [pixels], for a mouse and for a finger. */
const REACH = { mouse: 24, touch: 40 };
/** Pixels that a node may be farther from the pointer for each percent of the distance that it is nearer. */
const NEARER = 3;

interface Drag {
  readonly id: number;
  /** Plane of dragging: across the camera's view. */
  readonly plane: Plane;
  /** From what is pointed at on the plane to the node. */
  readonly offset: Vector3;
}

/** Pulls a twin with a mouse or a finger; what does not begin at the object moves the camera. */
export class PointerPull {
  readonly #ray = new Raycaster();
  #drag: Drag | null = null;

  /** `moved` is called when something was grabbed, drawn or released; nodes are `spacing` apart [m]. */
  constructor(
    private readonly stage: Stage,
    private readonly twin: LiveTwin,
    private readonly spacing: number,
    private readonly moved: () => void,
  ) {
    const { canvas } = stage;
    canvas.addEventListener('pointerdown', this.#down, { capture: true });
    canvas.addEventListener('pointermove', this.#move, { capture: true });
    for (const end of ['pointerup', 'pointercancel'] as const) canvas.addEventListener(end, this.#up, { capture: true });
  }

  readonly #down = (event: PointerEvent): void => {
    if (this.#drag !== null) return event.stopImmediatePropagation();
    if (event.button !== 0 || !event.isPrimary) return;
    const at = this.#at(event);
    const node = this.#nodeAt(at, event.pointerType === 'touch' ? REACH.touch : REACH.mouse);
    if (node === null) return;
    event.stopImmediatePropagation();
    const { canvas, camera } = this.stage;
    canvas.setPointerCapture(event.pointerId);
    const place = this.#place(node);
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), place);
    this.#drag = { id: event.pointerId, plane, offset: place.sub(this.#onPlane(plane, at) ?? place) };
    canvas.classList.add('is-dragging');
    this.twin.grab(node);
    this.moved();
  };

  readonly #move = (event: PointerEvent): void => {
    const drag = this.#drag;
    if (drag === null) {
      if (event.buttons === 0) this.stage.canvas.classList.toggle('can-drag', this.#nodeAt(this.#at(event), REACH.mouse) !== null);
      return;
    }
    event.stopImmediatePropagation();
    if (event.pointerId !== drag.id) return;
    const to = this.#onPlane(drag.plane, this.#at(event));
    if (to === null) return;
    this.twin.drag(...to.add(drag.offset).toArray());
    this.moved();
  };

  readonly #up = (event: PointerEvent): void => {
    if (this.#drag === null || event.pointerId !== this.#drag.id) return;
    event.stopImmediatePropagation();
    this.#drag = null;
    this.stage.canvas.classList.remove('is-dragging');
    this.twin.release();
    this.moved();
  };

  /** The node pointed at; of those within reach one in front. A node reaches as far as the distance between nodes. */
  #nodeAt(at: Vector2, reach: number): number | null {
    const { camera, canvas } = this.stage;
    const count = this.twin.nodes.length / 3;
    let [best, least] = [-1, Infinity];
    for (let node = 0; node < count; node += 1) {
      const place = this.#place(node);
      const depth = place.distanceTo(camera.position);
      const pixels = (canvas.clientHeight * camera.projectionMatrix.elements[5]!) / (2 * depth);
      const seen = this.stage.project(place);
      if (seen === null) continue;
      const distance = Math.hypot(seen.x - at.x, seen.y - at.y);
      if (distance > Math.max(reach, 0.75 * this.spacing * pixels)) continue;
      const cost = distance + NEARER * 100 * (depth / camera.position.distanceTo(this.stage.controls.target));
      if (cost < least) [best, least] = [node, cost];
    }
    return best < 0 ? null : best;
  }

  #place(node: number): Vector3 {
    return new Vector3().fromArray(this.twin.nodes, 3 * node);
  }

  #onPlane(plane: Plane, at: Vector2): Vector3 | null {
    const { canvas, camera } = this.stage;
    const seen = new Vector2((2 * at.x) / canvas.clientWidth - 1, 1 - (2 * at.y) / canvas.clientHeight);
    this.#ray.setFromCamera(seen, camera);
    return this.#ray.ray.intersectPlane(plane, new Vector3());
  }

  #at(event: PointerEvent): Vector2 {
    const box = this.stage.canvas.getBoundingClientRect();
    return new Vector2(event.clientX - box.left, event.clientY - box.top);
  }
}
