/** Bytes of the data of a playback: the first, and how many. */
export type Range = readonly [number, number];

/** Positions are `origin + scale_m * number`: docs/formats/playback.md. */
export interface MotionHead {
  readonly point_count: number;
  readonly control_count: number;
  readonly origin: readonly [number, number, number];
  readonly scale_m: number;
  /** int16 [T, P, 3] */
  readonly points: Range;
  /** Bits [T, P]; each frame begins on a byte boundary. */
  readonly visible: Range;
  /** int16 [T, C, 3] */
  readonly controls: Range;
  /** Hand of each control point, shape [C]; empty if unknown. */
  readonly control_hands?: readonly number[];
  /** Bytes [P, 3]. */
  readonly colors: Range | null;
}

export interface CameraHead {
  readonly name: string;
  /** Columns and rows of the recorded images, which the intrinsics are for. */
  readonly size: readonly [number, number];
  readonly intrinsics: { readonly fx: number; readonly fy: number; readonly cx: number; readonly cy: number };
  readonly distortion: { readonly model: string; readonly coefficients: readonly number[] };
  /** float32 [1 or K, 3, 4]; empty if the camera is not calibrated. */
  readonly poses: Range;
  readonly images: {
    readonly size: readonly [number, number];
    /** Image k is of frame `k * every`. */
    readonly every: number;
    readonly lengths: readonly number[];
    readonly bytes: Range;
  };
  /** Run lengths of the masks of each image, if there are masks. */
  readonly masks?: { readonly lengths: readonly number[]; readonly bytes: Range } | null;
  /** Doubt in the masks of each frame, 0..=1; null where it is unknown. Only of masks that strokes made. */
  readonly doubt?: readonly (number | null)[] | null;
}

export interface SequenceHead {
  readonly recording: number;
  readonly recording_name: string;
  readonly name: string;
  readonly fps: number;
  readonly frame_count: number;
  readonly train_frame_count: number;
  readonly start_frame: number;
  readonly ground: { readonly normal: readonly [number, number, number]; readonly offset_m: number } | null;
  readonly observed_points: number;
  readonly motion: MotionHead;
  readonly cameras: readonly CameraHead[];
}

export interface Head {
  readonly name: string;
  readonly sequences: readonly SequenceHead[];
  readonly left_out: number;
}

/** True if the capture has several recordings, which cannot be marked together. */
export function hasSeveralRecordings({ sequences }: Head): boolean {
  return sequences.some(({ recording }) => recording !== sequences[0]?.recording);
}

/** Bytes before the head. */
export const PREFIX = 16;
const MAGIC = 'BENDPLAY';
const VERSION = 1;

/** Length of the head, from the first bytes of a playback; throws if they are not those of one. */
export function headLength(bytes: Uint8Array): number {
  if (bytes.length < PREFIX || new TextDecoder().decode(bytes.subarray(0, MAGIC.length)) !== MAGIC) {
    throw new Error('this is not a playback of a capture');
  }
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const version = view.getUint32(MAGIC.length, true);
  if (version !== VERSION) throw new Error(`the playback has version ${version}, which is unknown to this page`);
  return view.getUint32(MAGIC.length + 4, true);
}

/** The head of a playback; throws if what it says cannot be. */
export function readHead(bytes: Uint8Array): Head {
  const head = JSON.parse(new TextDecoder().decode(bytes)) as Head;
  if (!Array.isArray(head.sequences)) throw new Error('the playback has no sequences');
  head.sequences.forEach(check);
  return head;
}

function check(sequence: SequenceHead): void {
  const { frame_count: frames, motion } = sequence;
  const { point_count: points, control_count: controls } = motion;
  const wanted: [string, number, number][] = [
    ['bytes of points', motion.points[1], 6 * frames * points],
    ['bytes of visible', motion.visible[1], frames * Math.ceil(points / 8)],
    ['bytes of controls', motion.controls[1], 6 * frames * controls],
    ['bytes of colors', motion.colors?.[1] ?? 3 * points, 3 * points],
  ];
  const sum = (lengths: readonly number[]): number => lengths.reduce((all, length) => all + length, 0);
  for (const { images, poses, masks, doubt } of sequence.cameras) {
    wanted.push(['bytes of images', images.bytes[1], sum(images.lengths)]);
    if (masks) {
      wanted.push(['bytes of masks', masks.bytes[1], sum(masks.lengths)]);
      wanted.push(['lengths of masks', masks.lengths.length, images.lengths.length]);
    }
    if (doubt) wanted.push(['values of doubt', doubt.length, frames]);
    // One that stands has one pose, one that is not calibrated none.
    if (poses[1] !== 48 && poses[1] !== 0) wanted.push(['bytes of poses', poses[1], 48 * images.lengths.length]);
    if (!(images.every >= 1)) throw new Error('the playback has images of no frames');
  }
  if (!(frames >= 1 && sequence.fps > 0)) throw new Error('the playback has a sequence without frames');
  const wrong = wanted.find(([, there, expected]) => there !== expected);
  if (wrong !== undefined) {
    throw new Error(`the playback has ${wrong[1]} ${wrong[0]} in place of ${wrong[2]}`);
  }
}
