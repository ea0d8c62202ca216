import { counted } from '../../../ui/format';
import type { Note, Survey } from './survey';

/** What a raw recording has. */
export interface Raw {
  readonly cameras: number;
  /** Frames of the camera with most; null if unknown. */
  readonly frames: number | null;
  /** Forms of its colour images, as `PNG`. */
  readonly color: readonly string[];
  readonly depth: boolean;
  readonly masks: boolean;
  readonly calibration: boolean;
  readonly tracks: boolean;
  readonly mesh: boolean;
}

/** The survey of a raw recording, with what can be done about what it lacks; `notes` are others. */
export function rawSurvey(format: string, raw: Raw, notes: readonly Note[]): Survey {
  const { cameras, frames, color, depth, masks, calibration, tracks, mesh } = raw;
  const hasImages = cameras > 0 && frames !== 0 && color.length > 0;
  const lacks: (Note | false)[] = [
    !hasImages && { text: 'No colour images were found: a recording is refused without.', section: 'recording' },
    !depth && { text: 'No depth of every camera was found: a twin needs it.', section: 'depth' },
    !masks && { text: 'No masks: you can mark the object and the hand after the upload, with a click each.', section: 'masks' },
    !calibration && { text: 'No calibration: a board that all cameras see in the recording can calibrate it.', section: 'calibration' },
  ];
  return {
    format,
    facts: [
      counted(cameras, 'camera'),
      ...(frames === null ? [] : [counted(frames, 'frame')]),
      ...(color.length > 0 ? [`${color.join(', ')} images`] : []),
    ],
    parts: [
      ['depth', depth],
      ['masks', masks],
      ['calibration', calibration],
      ...(tracks ? ([['tracks', true]] as const) : []),
      ...(mesh ? ([['mesh', true]] as const) : []),
    ],
    notes: [...notes, ...lacks.filter((note) => note !== false)],
    isComplete: hasImages && depth && masks && calibration && notes.length === 0,
  };
}
