import { Vector3 } from 'three';
import type { Driver } from './driver';
import { push, toggleGrasp } from './keys';
import type { PlayScene } from '../scene';

/** Sticks that are moved less than this are at rest. */
const DEAD = 0.15;
/** Numbers of buttons of the standard layout. */
const BUTTONS = { grasp: 0, previous: 4, next: 5 };

/** A gamepad: the left stick moves the selected gripper along the ground, the right one up and down. */
export class GamepadDrive {
  #last = 0;
  #pressed = new Set<number>();

  constructor(
    private readonly scene: PlayScene,
    private readonly driver: Driver,
    private readonly selected: () => void,
    signal: AbortSignal,
  ) {
    addEventListener('gamepadconnected', () => scene.stage.invalidate(), { signal });
  }

  /** Reads the gamepad; true while there is one. */
  frame(now: number): boolean {
    const elapsed = Math.min(now - this.#last, 50) / 1000;
    this.#last = now;
    const pad = navigator.getGamepads().find((found) => found?.connected);
    if (pad == null) return false;
    const [x = 0, y = 0, , z = 0] = pad.axes.map((axis) => (Math.abs(axis) < DEAD ? 0 : axis));
    if (x !== 0 || y !== 0 || z !== 0) push(this.scene, this.driver, new Vector3(x, -y, -z), elapsed);
    const pressed = new Set(Object.values(BUTTONS).filter((button) => pad.buttons[button]?.pressed === true));
    for (const button of pressed) if (!this.#pressed.has(button)) this.#press(button);
    this.#pressed = pressed;
    return true;
  }

  #press(button: number): void {
    const { usable } = this.driver;
    if (button === BUTTONS.grasp) toggleGrasp(this.scene, this.driver);
    else {
      const at = usable.indexOf(this.driver.selected) + (button === BUTTONS.next ? 1 : -1) + usable.length;
      this.driver.selected = usable[at % usable.length] ?? 0;
    }
    this.selected();
  }
}
