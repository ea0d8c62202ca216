import type { Api } from '../../../api/client';
import { Ground } from '../../../view3d/place/ground';
import { Legend } from '../../../view3d/legend';
import { loadShape, type TwinShape } from '../../../view3d/shape';
import { Stage } from '../../../view3d/stage';
import { TwinView } from '../../../view3d/twin_view';
import type { Moving } from './moving';

/** Turns of the camera around a twin in a minute. */
const TURNS = 3;

/** A twin at rest that turns. */
export class TwinScene implements Moving {
  readonly stage = new Stage('The twin');
  readonly #view: TwinView;
  #turns = false;

  private constructor(shape: TwinShape) {
    this.#view = new TwinView(this.stage, shape, new Legend());
    this.#view.above(shape.ground);
    new Ground(this.stage, shape.rest).place(shape.ground);
    this.stage.lookAt(shape.rest);
    const { controls } = this.stage;
    controls.autoRotateSpeed = TURNS;
    this.stage.beforeFrame(() => {
      if (this.#turns) controls.update();
      return this.#turns;
    });
  }

  /** Loads the shape of a twin by its id. */
  static async open(api: Api, twin: string, signal: AbortSignal): Promise<TwinScene> {
    return new TwinScene(await loadShape(api, twin, signal));
  }

  play(): void {
    this.#turns = this.stage.controls.autoRotate = true;
    this.stage.invalidate();
  }

  pause(): void {
    this.#turns = this.stage.controls.autoRotate = false;
  }

  dispose(): void {
    this.pause();
    this.#view.dispose();
    this.stage.dispose();
  }
}
