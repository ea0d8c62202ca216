import { Spherical, Vector3 } from 'three';
import type { Stage } from './stage';

/** Turn of one key press [rad], and factor of the distance. */
const TURN = Math.PI / 24;
const ZOOM = 1.1;

/**
 * Keys of the camera: arrows turn it around its target, with Control they move both, plus and minus
 * zoom. Where arrows have another meaning, these need Shift.
 */
export class CameraKeys {
  readonly #stage: Stage;
  readonly #needsShift: boolean;

  constructor(stage: Stage, needsShift: boolean) {
    this.#stage = stage;
    this.#needsShift = needsShift;
    stage.canvas.addEventListener('keydown', this.#press);
  }

  dispose(): void {
    this.#stage.canvas.removeEventListener('keydown', this.#press);
  }

  readonly #press = (event: KeyboardEvent): void => {
    if (event.altKey || event.metaKey || event.defaultPrevented) return;
    if (event.key === '+' || event.key === '=') this.#zoom(1 / ZOOM);
    else if (event.key === '-') this.#zoom(ZOOM);
    else {
      const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (way === undefined || (this.#needsShift && !event.shiftKey)) return;
      const [x, y] = way as [number, number];
      if (event.ctrlKey) this.#shift(x, y);
      else this.#turn(x, y);
    }
    this.#stage.unframe();
    event.preventDefault();
  };

  #turn(x: number, y: number): void {
    const { camera, controls } = this.#stage;
    const offset = camera.position.clone().sub(controls.target);
    // Spherical counts from y, and up is z here.
    const place = new Spherical().setFromCartesianCoords(offset.x, offset.z, -offset.y);
    place.theta += TURN * x;
    place.phi = Math.min(Math.max(place.phi - TURN * y, 0.02), Math.PI - 0.02);
    const turned = new Vector3().setFromSpherical(place);
    camera.position.copy(controls.target).add(new Vector3(turned.x, -turned.z, turned.y));
    controls.update();
    this.#stage.invalidate();
  }

  #shift(x: number, y: number): void {
    const { camera, controls } = this.#stage;
    const step = camera.position.distanceTo(controls.target) / 20;
    const right = new Vector3().setFromMatrixColumn(camera.matrix, 0).multiplyScalar(x * step);
    const up = new Vector3().setFromMatrixColumn(camera.matrix, 1).multiplyScalar(y * step);
    camera.position.add(right).add(up);
    controls.target.add(right).add(up);
    controls.update();
    this.#stage.invalidate();
  }

  #zoom(factor: number): void {
    const { camera, controls } = this.#stage;
    camera.position.sub(controls.target).multiplyScalar(factor).add(controls.target);
    controls.update();
    this.#stage.invalidate();
  }
}
