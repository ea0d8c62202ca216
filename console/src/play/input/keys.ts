import { Vector3 } from 'three';
import type { Driver } from './driver';
import type { PlayScene } from '../scene';

/** Speed of a gripper that keys or a stick move, as a share of the object's size in a second. */
export const SPEED = 0.6;

const WAYS: Readonly<Record<string, readonly [number, number, number]>> = {
  ArrowLeft: [-1, 0, 0],
  ArrowRight: [1, 0, 0],
  ArrowUp: [0, 1, 0],
  ArrowDown: [0, -1, 0],
  PageUp: [0, 0, 1],
  PageDown: [0, 0, -1],
};

/** Keys of the picture: arrows and page keys move the selected gripper, Tab selects, space grasps and releases. */
export class GripperKeys {
  readonly #pressed = new Set<string>();
  #last = 0;

  constructor(
    private readonly scene: PlayScene,
    private readonly driver: Driver,
    private readonly selected: () => void,
  ) {
    const { canvas } = scene.stage;
    canvas.addEventListener('keydown', this.#down);
    canvas.addEventListener('keyup', (event) => this.#pressed.delete(event.key));
    canvas.addEventListener('blur', () => this.#pressed.clear());
  }

  /** Moves the selected gripper for the time since the last frame; true while a key is pressed. */
  frame(now: number): boolean {
    const elapsed = Math.min(now - this.#last, 50) / 1000;
    this.#last = now;
    const way = new Vector3();
    for (const key of this.#pressed) way.add(new Vector3(...(WAYS[key] ?? [0, 0, 0])));
    if (way.lengthSq() > 0) push(this.scene, this.driver, way.normalize(), elapsed);
    return this.#pressed.size > 0;
  }

  readonly #down = (event: KeyboardEvent): void => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === 'Tab') return this.#tab(event);
    if (event.key === ' ') {
      event.preventDefault();
      if (!event.repeat) toggleGrasp(this.scene, this.driver, event.timeStamp);
      return this.selected();
    }
    if (event.shiftKey || WAYS[event.key] === undefined) return;
    event.preventDefault();
    if (this.#pressed.size === 0) this.#last = performance.now();
    this.#pressed.add(event.key);
    this.scene.stage.invalidate();
  };

  /** The next gripper, or after the last one out of the picture, as Tab does elsewhere. */
  #tab(event: KeyboardEvent): void {
    const { usable } = this.driver;
    const next = usable[usable.indexOf(this.driver.selected) + (event.shiftKey ? -1 : 1)];
    if (next === undefined) return;
    event.preventDefault();
    this.driver.selected = next;
    this.selected();
    this.scene.stage.invalidate();
  }
}

/** Moves the selected gripper: x to the right and y away from the camera along the ground, z up. */
export function push(scene: PlayScene, driver: Driver, way: Vector3, seconds: number): void {
  const ahead = scene.stage.camera.getWorldDirection(new Vector3()).setZ(0);
  if (ahead.lengthSq() < 1e-6) ahead.set(0, 1, 0);
  ahead.normalize();
  const right = new Vector3(ahead.y, -ahead.x, 0);
  const step = SPEED * scene.size * seconds;
  const to = driver.targetOf(driver.selected);
  to.addScaledVector(right, way.x * step).addScaledVector(ahead, way.y * step);
  to.z += way.z * step;
  driver.move(driver.selected, to.clampScalar(-99, 99));
}

/** Lets the selected gripper go, or lets it take hold of the nearest node. */
export function toggleGrasp(scene: PlayScene, driver: Driver, time = performance.now()): void {
  const { selected } = driver;
  if (driver.isHolding(selected) || driver.held.has(selected)) return driver.release(selected, time);
  const node = scene.nearest(driver.targetOf(selected));
  if (node !== null) driver.grasp(selected, node, time);
}
