import { Box3, Vector3 } from 'three';
import type { Api } from '../../../api/client';
import { visiblePoints } from '../../../playback/extent';
import { PlaybackFile } from '../../../playback/file/file';
import type { SequenceHead } from '../../../playback/file/head';
import { Motion, type Frame } from '../../../playback/file/motion';
import { PointsLayer } from '../../../view3d/layers/points';
import { Ground } from '../../../view3d/place/ground';
import { Stage } from '../../../view3d/stage';
import type { Moving } from '../../../view3d/moving/moving';
import { pointsOf, type Preview } from './preview';

/** Colours of recorded and of predicted points, as pages of playbacks have them. */
const COLOURS = { observed: 0x2f6fd0, predicted: 0x0ca678 };
/** Frames that are shown of a recording without a preview, as many as a preview has. */
const FRAMES = 24;
/** Time of a frame, and of the last one, before the motion begins again [ms]. */
const FRAME_MS = 120;
const LAST_MS = 900;

/** The recording in blue and what a fit predicts in green, in a loop. */
export class PreviewScene implements Moving {
  readonly stage = new Stage('The recording and what the fit predicts of it so far');
  #observed: PointsLayer | null = null;
  #predicted: PointsLayer | null = null;
  #preview: Preview | null = null;
  #frames: readonly number[] = [];
  /** Recorded frames by their numbers. */
  readonly #recorded = new Map<number, Frame>();
  #index = 0;
  #timer = 0;
  #isDisposed = false;

  /** Made with the first points that are known. */
  #ground: Ground | null = null;

  private constructor(private readonly file: PlaybackFile | null) {}

  /** Opens the recording of a capture, if there is one that can be shown. */
  static async open(api: Api, capture: string, signal: AbortSignal): Promise<PreviewScene> {
    const scene = new PreviewScene(await PlaybackFile.open(api, capture, signal).catch(() => null));
    await scene.#record(0);
    return scene;
  }

  /** True if there is anything to see. */
  get hasPoints(): boolean {
    return this.#observed !== null || this.#predicted !== null;
  }

  /** Shows a preview in the place of the one before. */
  async show(preview: Preview): Promise<void> {
    const { sequence, frames } = preview;
    const isOther = this.#preview?.sequence !== sequence || this.#frames.join() !== frames.join();
    if (isOther) await this.#record(sequence, [...frames]);
    if (this.#isDisposed) return;
    const points = pointsOf(preview, 0);
    if (this.#predicted?.positions.length !== points.length) {
      if (this.#predicted !== null) this.stage.remove(this.#predicted);
      const size = sizeOf(points);
      this.#predicted = this.stage.add(new PointsLayer(points.slice(), { size, colour: COLOURS.predicted }));
      if (this.#observed === null) this.stage.lookAt(preview.positions);
    }
    this.#preview = preview;
    this.#draw();
  }

  play(): void {
    if (this.#timer !== 0 || this.#isDisposed) return;
    const isLast = this.#index === this.#frames.length - 1;
    this.#timer = window.setTimeout(() => {
      this.#timer = 0;
      this.#index = isLast ? 0 : this.#index + 1;
      if (!document.hidden) this.#draw();
      this.play();
    }, isLast ? LAST_MS : FRAME_MS);
  }

  pause(): void {
    clearTimeout(this.#timer);
    this.#timer = 0;
  }

  dispose(): void {
    this.#isDisposed = true;
    this.pause();
    this.stage.dispose();
  }

  /** Loads frames of the recording, by default some that are spread over all. */
  async #record(index: number, wanted?: readonly number[]): Promise<void> {
    const sequence = this.file?.head.sequences[index];
    const frames = wanted ?? (sequence === undefined ? [] : spread(sequence));
    this.#recorded.clear();
    if (this.file !== null && sequence !== undefined) {
      const { file } = this;
      const motion = new Motion(sequence.motion, sequence.frame_count, (range) => file.read(range));
      for (const frame of frames.filter((frame) => frame < sequence.frame_count)) {
        await motion.load(frame);
        const loaded = motion.frame(frame);
        if (loaded !== null) this.#recorded.set(frame, loaded);
      }
    }
    if (this.#isDisposed) return;
    [this.#frames, this.#index] = [frames, 0];
    if (this.#observed !== null) this.stage.remove(this.#observed);
    this.#observed = null;
    const all = [...this.#recorded.values()];
    if (sequence === undefined || all.length === 0) return;
    const { point_count: count } = sequence.motion;
    const positions = new Float32Array(3 * Math.max(count, 1));
    const seen = all.map((frame) => visiblePoints(frame).points);
    const size = sizeOf(seen[0]!);
    this.#observed = this.stage.add(new PointsLayer(positions, { size, colour: COLOURS.observed }));
    this.#ground ??= new Ground(this.stage, seen[0]!);
    this.#ground.place(sequence.ground);
    this.stage.lookAt(Float32Array.from(seen.flatMap((points) => [...points])));
    this.#draw();
  }

  /** Shows the frame that is due. */
  #draw(): void {
    const recorded = this.#recorded.get(this.#frames[this.#index] ?? -1);
    if (this.#observed !== null && recorded !== undefined) {
      const seen = visiblePoints(recorded).points;
      this.#observed.positions.set(seen);
      this.#observed.moved(seen.length / 3);
    }
    if (this.#predicted !== null && this.#preview !== null) {
      this.#predicted.positions.set(pointsOf(this.#preview, this.#index));
      this.#predicted.moved();
    }
    this.stage.invalidate();
  }
}

/** Numbers of frames of a sequence, spread evenly from its start to its end. */
function spread({ start_frame: first, frame_count: count }: SequenceHead): number[] {
  const taken = Math.min(FRAMES, count - first);
  const steps = Math.max(taken - 1, 1);
  return Array.from({ length: taken }, (_, i) => first + Math.floor((i * (count - 1 - first)) / steps));
}

/** A diameter at which points [M, 3] cover about half of their object [m]. */
function sizeOf(points: Float32Array): number {
  const box = new Box3().setFromArray([...points]);
  const extent = box.isEmpty() ? 0 : Math.max(...box.getSize(new Vector3()).toArray());
  // Few points stay small beside it.
  return Math.max(extent * Math.min(0.6 / Math.sqrt(Math.max(points.length / 3, 1)), 0.04), 0.002);
}
