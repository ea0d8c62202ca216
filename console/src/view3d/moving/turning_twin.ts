import { Legend } from '../legend';
import { Ground } from '../place/ground';
import type { TwinShape } from '../shape';
import { Stage } from '../stage';
import { TwinView } from '../twin_view';
import type { Moving } from './moving';

/** Time of a full turn [s]. */
const TURN_S = 30;
/** Longest step of a turn, after a picture that came late [s]. */
const MOST_STEP_S = 0.1;

export interface TurningOptions {
  /** What the picture shows, for those who do not see it. */
  readonly label: string;
  /** True if it stands on its ground, with a shadow, instead of alone. */
  readonly hasGround?: boolean;
  /** Called when somebody takes hold of it, after which it stands still. */
  readonly onHeld?: () => void;
}

/** A twin at rest that turns slowly in its own colours, while it is seen and until somebody takes hold of it. */
export class TurningTwin implements Moving {
  readonly stage: Stage;
  readonly #view: TwinView;
  readonly #seen: IntersectionObserver;
  #turns = false;
  #isSeen = true;
  #last = 0;

  constructor(shape: TwinShape, { label, hasGround = false, onHeld }: TurningOptions) {
    this.stage = new Stage(label, 'img', { isSmooth: true });
    const { canvas, controls } = this.stage;
    this.#view = new TwinView(this.stage, shape, new Legend());
    if (hasGround) {
      this.#view.above(shape.ground);
      new Ground(this.stage, shape.rest).place(shape.ground);
    } else this.#view.show(new Set(['skin', 'appearance']));
    this.stage.lookAt(shape.rest);
    // The page is scrolled by the wheel, and by fingers that move up or down.
    controls.enableZoom = false;
    controls.enablePan = false;
    canvas.style.touchAction = 'pan-y';
    controls.autoRotateSpeed = 60 / TURN_S;
    const hold = (): void => {
      this.pause();
      onHeld?.();
    };
    for (const event of ['pointerdown', 'keydown']) canvas.addEventListener(event, hold);
    this.stage.beforeFrame((now) => this.#turn(now));
    this.#seen = new IntersectionObserver(([entry]) => {
      this.#isSeen = entry?.isIntersecting ?? false;
      this.stage.invalidate();
    });
    this.#seen.observe(this.stage.element);
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
    this.#seen.disconnect();
    this.#view.dispose();
    this.stage.dispose();
  }

  #turn(now: number): boolean {
    if (!this.#turns || !this.#isSeen) return false;
    // After a rest it continues where it was.
    const seconds = Math.min(Math.max(now - this.#last, 0) / 1000, MOST_STEP_S);
    this.#last = now;
    this.stage.controls.update(seconds);
    return true;
  }
}
