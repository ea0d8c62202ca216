import type { Stage } from '../stage';

/** A picture in three dimensions that moves by itself until it is paused. */
export interface Moving {
  readonly stage: Stage;
  play(): void;
  pause(): void;
  /** Frees everything. */
  dispose(): void;
}
