import { millimetres } from '../../ui/format';
import type { Cameras } from '../camera/cameras';
import type { Clock } from '../clock';
import type { Look } from '../look';
import type { Player } from '../player';
import type { Scene } from '../scene';
import type { Subject } from './video';

/** What the page draws with. */
export interface Parts {
  readonly scene: Scene;
  readonly player: Player;
  readonly look: Look;
  readonly cameras: Cameras | null;
}

/** What is written into a video. */
export interface Facts {
  /** Of the capture. */
  readonly name: string;
  /** Of the twin; may be empty. */
  readonly twin: string;
  readonly signal: AbortSignal;
  /** Error in each frame [m], shape [T]; empty without a prediction. */
  readonly errors: readonly (number | null)[];
  readonly trainFrameCount: number;
}

/** The subject of a video: all that is seen now, from the first frame to the last, at the speed of the clock. */
export function subjectOf({ scene, player, look, cameras }: Parts, clock: Clock, facts: Facts): Subject {
  const { frame: shown, frameCount, fps, speed } = clock;
  const { name, twin, signal, errors, trainFrameCount } = facts;
  const isPredicted = player.twin !== null && look.prediction;
  clock.pause();
  return {
    name, frameCount, fps, speed, signal,
    draw: async (frame) => {
      clock.seek(frame);
      await player.load(frame);
      player.draw(frame);
    },
    panels: () => {
      scene.stage.drawNow();
      const space = { source: scene.stage.canvas, label: isPredicted ? 'Prediction' : 'Tracked points' };
      if (cameras === null) return [space];
      const label = `Recorded by ${cameras.name}${isPredicted ? ', with the prediction' : ''}`;
      return [{ source: cameras.canvas, label }, space];
    },
    texts: (frame) => {
      const error = errors[frame] ?? null;
      const part = frame < trainFrameCount ? 'for fitting' : 'future';
      const said = error === null ? '' : `, error ${millimetres(error)}`;
      const ofTwin = twin === '' || twin === name ? '' : `, twin ${twin}`;
      return [`${name}${ofTwin}`, `${(frame / fps).toFixed(2)} s, ${part}${said}`];
    },
    end: () => clock.seek(shown),
  };
}
