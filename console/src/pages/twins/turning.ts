import type { PageContext } from '../../page';
import { Legend } from '../../view3d/legend';
import type { TwinShape } from '../../view3d/shape';
import { Stage } from '../../view3d/stage';
import { TwinView } from '../../view3d/twin_view';

/** Time of a full turn [s]. */
const TURN_S = 30;

/** A twin that turns slowly in its own colours until somebody takes hold of it. */
export class Turning {
  readonly element: HTMLElement;
  readonly #stage: Stage;
  readonly #view: TwinView;
  #turns = !matchMedia('(prefers-reduced-motion: reduce)').matches;
  #last = 0;

  constructor(name: string, shape: TwinShape, { signal }: PageContext) {
    this.#stage = new Stage(`The twin ${name}: drag to rotate`);
    const { canvas, controls } = this.#stage;
    this.element = this.#stage.element;
    this.#view = new TwinView(this.#stage, shape, new Legend());
    this.#view.show(new Set(['skin', 'appearance']));
    this.#stage.lookAt(shape.rest);
    // The page is scrolled by the wheel, and by fingers that move up or down.
    controls.enableZoom = false;
    controls.enablePan = false;
    canvas.style.touchAction = 'pan-y';
    controls.autoRotate = this.#turns;
    controls.autoRotateSpeed = 60 / TURN_S;
    for (const event of ['pointerdown', 'keydown']) canvas.addEventListener(event, () => this.#stop(), { signal });
    this.#stage.beforeFrame((now) => this.#turn(now));
    this.#rest(signal);
  }

  dispose(): void {
    this.#view.dispose();
    this.#stage.dispose();
  }

  #turn(now: number): boolean {
    if (!this.#turns) return false;
    // After a rest it continues where it was.
    const seconds = Math.min(Math.max(now - this.#last, 0) / 1000, 0.1);
    this.#last = now;
    this.#stage.controls.update(seconds);
    return true;
  }

  #stop(): void {
    this.#turns = false;
    this.#stage.controls.autoRotate = false;
  }

  /** Rests while it is scrolled out of view. */
  #rest(signal: AbortSignal): void {
    if (!this.#turns) return;
    const seen = new IntersectionObserver(([entry]) => {
      const { controls } = this.#stage;
      // Once stopped by hand it stays so.
      if (!controls.autoRotate) return seen.disconnect();
      this.#turns = entry?.isIntersecting ?? false;
      this.#stage.invalidate();
    });
    seen.observe(this.element);
    signal.addEventListener('abort', () => seen.disconnect());
  }
}
