import type { Api } from '../../api/client';
import { PhotographLayer } from '../../view3d/layers/photograph';
import { PointsLayer } from '../../view3d/layers/points';
import { middleOf, type Ground } from '../../view3d/place/ground';
import type { TwinShape } from '../../view3d/shape';
import type { Layer, Stage } from '../../view3d/stage';
import { RecordedScene } from './recorded_scene';

/** What a background is chosen by: `grid`, `none`, `points`, or `camera-` and the number of one. */
export type Choice = string;

/** Colour of recorded points whose colours are unknown. */
const POINTS = 0x2f6fd0;

/** What is around a twin: a ground, nothing, or what was recorded. */
export class Background {
  /** What is shown. */
  choice: Choice = 'grid';
  /** Called when an image was left because the view was moved. */
  onLeave: () => void = () => undefined;
  #scene: Promise<RecordedScene | null> | null = null;
  #layer: Layer | null = null;
  #asked = 0;

  /** `open` opens the recording; null without one. */
  constructor(
    private readonly stage: Stage,
    private readonly ground: Ground,
    private readonly shape: TwinShape,
    private readonly open: (() => Promise<RecordedScene | null>) | null,
  ) {}

  /** The background of a twin that was fitted to a capture. */
  static of(
    { stage, ground, shape }: { readonly stage: Stage; readonly ground: Ground; readonly shape: TwinShape },
    { api, signal }: { readonly api: Api; readonly signal: AbortSignal },
    capture: string | null,
  ): Background {
    const open = capture === null ? null : () => RecordedScene.open(api, capture, signal);
    return new Background(stage, ground, shape, open);
  }

  /** What there is to choose from, with its text. */
  async choices(): Promise<readonly (readonly [Choice, string])[]> {
    const scene = await this.#recorded();
    const points = scene?.hasPoints === true ? [['points', 'the recorded points'] as const] : [];
    const cameras = (scene?.cameras ?? []).map(([index, name]) => [`camera-${index}`, `the image of camera ${name}`] as const);
    return [...PLAIN, ...points, ...cameras];
  }

  /** Shows something else; throws if it cannot be loaded. */
  async show(choice: Choice): Promise<void> {
    const asked = (this.#asked += 1);
    const camera = /^camera-(\d+)$/.exec(choice)?.[1];
    const scene = choice === 'points' || camera !== undefined ? await this.#recorded() : null;
    const photograph = camera === undefined ? null : await scene?.photograph(Number(camera));
    const points = choice === 'points' ? await scene?.points() : null;
    // Something else was chosen meanwhile.
    if (asked !== this.#asked) return;
    this.#clear();
    this.choice = choice;
    this.ground.isShown = choice === 'grid' || choice === 'points';
    if (photograph) {
      this.#layer = this.stage.add(new PhotographLayer(photograph));
      this.stage.lookThrough(photograph, middleOf(this.shape.rest), () => this.#leave());
    } else if (points) {
      const layer = new PointsLayer(points.points, { size: 0.3 * this.shape.spacing, colour: POINTS });
      if (points.colours !== null) layer.tint(points.colours);
      this.#layer = this.stage.add(layer);
    }
  }

  /** The view has been moved: an image fits it no more. */
  #leave(): void {
    if (this.#layer instanceof PhotographLayer) void this.show('grid').then(this.onLeave);
  }

  #clear(): void {
    const layer = this.#layer;
    this.#layer = null;
    if (layer === null) return;
    if (layer instanceof PhotographLayer) this.stage.unframe();
    this.stage.remove(layer);
  }

  #recorded(): Promise<RecordedScene | null> {
    if (this.open === null) return Promise.resolve(null);
    this.#scene ??= this.open();
    // What failed is asked for again.
    this.#scene.catch(() => (this.#scene = null));
    return this.#scene;
  }
}

/** What there is without a recording. */
export const PLAIN: readonly (readonly [Choice, string])[] = [['grid', 'a ground with a grid'], ['none', 'nothing']];
