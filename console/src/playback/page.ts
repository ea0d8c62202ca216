import { Problem } from '../api/client';
import type { OpenPage, PageContext } from '../page';
import { shareMenu } from '../play/share/menu';
import { h } from '../ui/dom';
import { counted } from '../ui/format';
import { problemBox } from '../ui/problem';
import { loadShape } from '../view3d/shape';
import type { TwinLayer } from '../view3d/twin_view';
import { CameraView } from './camera/camera_view';
import { ErrorChart } from './chart';
import { choice, sequenceChoice, twinChoice } from './choices';
import { Clock } from './clock';
import { PlaybackFile } from './file/file';
import type { SequenceHead } from './file/head';
import { readLook, writeLook, type Look } from './look';
import { lookControls } from './look_controls';
import { Motion } from './file/motion';
import { Player } from './player';
import { Prediction } from './prediction';
import { Scene } from './scene';
import { Timeline, keyOf } from './timeline';
import '../play/play.css';
import './playback.css';

/** Time after the last change after which the address names the moment [ms]. */
const ADDRESS_MS = 300;

/** The playback of a capture: what was observed, what cameras saw, and what a twin predicts. */
export const open: OpenPage = async (context) => {
  const { api, signal } = context;
  const id = context.parameters['id'] ?? '';
  const capture = await api.get('/v1/captures/{id}', { id, signal });
  const title = capture.display_name || 'Capture without a name';
  context.setTitle(`Playback of ${title}`);
  let file: PlaybackFile;
  try {
    file = await PlaybackFile.open(api, id, signal);
  } catch (error) {
    if (error instanceof Problem && error.reason === 'PLAYBACK_MISSING') return { element: missing(id, error) };
    throw error;
  }
  const asked = Number(context.query.get('sequence') ?? 0);
  const index = Number.isInteger(asked) && asked in file.head.sequences ? asked : 0;
  const sequence = file.head.sequences[index];
  if (sequence === undefined) return { element: h('p', {}, 'This capture has no sequence to play.') };
  if (sequence.motion.point_count === 0) return { element: withoutPoints(id) };
  const page = await PlaybackPage.load({ context, id, name: title, file, index, sequence });
  return { element: page.element, dispose: () => page.dispose() };
};

/** Replacement for a missing playback. */
function missing(id: string, error: Problem): HTMLElement {
  return h('div', {}, problemBox(error), h('p', {}, toCapture(id)));
}

/** Replacement for points that are not there: of a recording that was refused, or read up to masks alone. */
function withoutPoints(id: string): HTMLElement {
  const text = 'This capture has no points to play: its page says what the last reading came to, and shows its images.';
  return h('div', { class: 'empty' }, h('p', {}, text), toCapture(id));
}

function toCapture(id: string): HTMLElement {
  return h('a', { class: 'button', href: `#/captures/${id}` }, 'To the capture');
}

/** A sequence that is to be played. */
interface Opened {
  readonly context: PageContext;
  readonly id: string;
  readonly name: string;
  readonly file: PlaybackFile;
  readonly index: number;
  readonly sequence: SequenceHead;
}

class PlaybackPage {
  readonly element: HTMLElement;
  readonly #clock: Clock;
  readonly #timeline: Timeline;
  readonly #chartPlace = h('div', { 'aria-live': 'polite' });
  readonly #cameraPlace = h('div', { class: 'playback-cameras' });
  readonly #twinPlace = h('span');
  readonly #faults = h('div');
  #chart: ErrorChart | null = null;
  #camera = 0;
  #address = 0;
  #loading = -1;

  private constructor(
    private readonly opened: Opened,
    private readonly scene: Scene,
    private readonly player: Player,
    private readonly look: Look,
  ) {
    const { context, sequence } = opened;
    const { query } = context;
    this.#clock = new Clock(sequence.frame_count, sequence.fps, Number(query.get('frame') ?? 0), () => this.#changed());
    this.#timeline = new Timeline(this.#clock, sequence.train_frame_count);
    const camera = Number(query.get('camera'));
    this.#camera = camera in sequence.cameras ? camera : 0;
    this.element = this.#build();
    scene.stage.controls.addEventListener('end', () => this.#name());
    scene.stage.beforeFrame((now) => {
      this.#clock.tick(now, (frame) => this.#isHere(frame));
      return this.#clock.isPlaying;
    });
    context.signal.addEventListener('abort', () => clearTimeout(this.#address));
    document.addEventListener('keydown', this.#key);
    this.#showCamera();
    this.#changed();
    void this.#loadTwins();
    void this.#predict();
  }

  static async load(opened: Opened): Promise<PlaybackPage> {
    const { context, file, sequence, name } = opened;
    const read = file.read.bind(file);
    const motion = new Motion(sequence.motion, sequence.frame_count, read);
    const [colors] = await Promise.all([
      sequence.motion.colors === null ? null : read(sequence.motion.colors),
      motion.load(0),
      motion.load(sequence.frame_count - 1),
    ]);
    const look = readLook(context.query, colors !== null);
    const ends = [0, sequence.frame_count - 1].flatMap((frame) => motion.frame(frame) ?? []);
    const scene = new Scene(sequence, ends, `Points of ${name}`);
    const player = new Player(motion, scene, colors, look);
    return new PlaybackPage(opened, scene, player, look);
  }

  dispose(): void {
    document.removeEventListener('keydown', this.#key);
    this.#chart?.dispose();
    this.player.camera?.dispose();
    this.scene.dispose();
  }

  #build(): HTMLElement {
    const { context, id, file, index, sequence, name } = this.opened;
    const { motion, cameras } = sequence;
    const controls = lookControls(this.look, motion.colors !== null, () => {
      this.#showLayers();
      this.#changed();
    });
    const names = cameras.map((camera, i) => [String(i), camera.name || String(i)] as const);
    const cameraChoice = names.length < 2 ? null : choice('Camera', names, String(this.#camera), (value) => {
      this.#camera = Number(value);
      this.#showCamera();
      this.#changed();
    });
    const all = sequence.observed_points;
    const thinned = motion.point_count < all ? ` of ${counted(all, 'point')}` : '';
    const facts =
      `${counted(motion.point_count, 'point')}${thinned}, ${counted(motion.control_count, 'control point')}, ` +
      `${counted(sequence.frame_count, 'frame')} at ${Number(sequence.fps.toPrecision(4))} frames a second`;
    this.scene.stage.describe(`${facts}. Space plays, comma and full stop step.`);
    const missed = file.head.left_out;
    const leftOut = missed > 0 ? ` For lack of space ${counted(missed, 'more sequence')} were left out.` : '';
    return h('div', { class: 'playback' },
      h('div', { class: 'row' },
        sequenceChoice(file.head, index, (other) => this.#go({ sequence: String(other), frame: '0' })),
        this.#twinPlace, cameraChoice,
        h('a', { href: `#/captures/${id}` }, 'The capture')),
      controls,
      this.#faults,
      h('div', { class: cameras.length === 0 ? 'playback-views' : 'playback-views playback-two' },
        this.scene.stage.element, cameras.length === 0 ? null : this.#cameraPlace),
      this.#timeline.element,
      this.#chartPlace,
      h('p', { class: 'hint' }, `${facts}.${leftOut} Keys: Space plays, comma and full stop step.`),
      shareMenu(this.scene.stage, context, () => this.#query(), name));
  }

  #showCamera(): void {
    const { sequence, file } = this.opened;
    const camera = sequence.cameras[this.#camera];
    if (camera === undefined) return;
    this.player.camera?.dispose();
    this.player.camera = new CameraView(camera, file.read.bind(file), () => this.player.draw(this.#clock.frame));
    this.#cameraPlace.replaceChildren(this.player.camera.element);
  }

  async #loadTwins(): Promise<void> {
    const { context, id } = this.opened;
    try {
      const chosen = context.query.get('twin') ?? '';
      this.#twinPlace.replaceWith(await twinChoice(context, id, chosen, (twin) => this.#go({ twin })));
    } catch (error) {
      this.#fail(error);
    }
  }

  /** Loads the prediction of the twin that the address names. */
  async #predict(): Promise<void> {
    const { context, id, index, sequence } = this.opened;
    const { scene } = this;
    const { api, signal } = context;
    scene.stage.setView(context.query.get('view') ?? '');
    const twin = context.query.get('twin') ?? '';
    if (twin === '') return;
    this.#chartPlace.replaceChildren(h('p', { class: 'hint' }, 'The twin is simulated beside the recording…'));
    try {
      const [shape, prediction] = await Promise.all([
        loadShape(api, twin, signal), Prediction.load(api, { twin, capture: id, sequence: index }, signal),
      ]);
      if (signal.aborted) return;
      this.player.twin = { prediction, shape };
      scene.setTwin(shape);
      this.#chart = new ErrorChart(prediction, sequence.frame_count, (frame) => {
        this.#clock.pause();
        this.#clock.seek(frame);
      });
      const warnings = prediction.warnings.map((warning) => h('p', { class: 'hint' }, warning));
      const summary = h('p', { class: 'hint' }, this.#chart.summary());
      this.#chartPlace.replaceChildren(this.#chart.element, summary, ...warnings);
      this.element.classList.add('playback-predicted');
      this.#showLayers();
      scene.stage.setView(context.query.get('view') ?? '');
      this.#changed();
    } catch (error) {
      this.#chartPlace.replaceChildren();
      this.#fail(error);
    }
  }

  #showLayers(): void {
    const { look } = this;
    const layers = new Set<TwinLayer>();
    const hasLook = (this.player.twin?.shape.appearance ?? null) !== null;
    if (look.prediction && look.appearance && hasLook) layers.add('skin').add('appearance');
    else if (look.prediction) layers.add('nodes');
    if (look.prediction && look.springs) layers.add('springs');
    this.scene.showTwin(layers, look.prediction && look.beside && this.player.twin !== null);
  }

  /** Draws what has changed, and loads what it lacks. */
  #changed(): void {
    const { frame, isPlaying } = this.#clock;
    this.#timeline.show();
    this.#chart?.show(frame);
    this.player.draw(frame);
    this.#isHere(frame);
    if (isPlaying) this.scene.stage.invalidate();
    else this.#name();
  }

  /** True if a frame can be drawn; it is loaded otherwise. */
  #isHere(frame: number): boolean {
    if (this.player.has(frame)) {
      // What follows is loaded before it is needed.
      if (this.#clock.isPlaying) void this.player.load(frame).catch(() => undefined);
      return true;
    }
    if (this.#loading === frame) return false;
    this.#loading = frame;
    this.player.load(frame).then(
      () => {
        if (this.#loading === frame) this.#loading = -1;
        this.player.draw(this.#clock.frame);
        this.scene.stage.invalidate();
      },
      (error: unknown) => {
        this.#loading = -1;
        this.#clock.pause();
        this.#fail(error);
      },
    );
    return false;
  }

  #fail(error: unknown): void {
    if (!this.opened.context.signal.aborted) this.#faults.replaceChildren(problemBox(error));
  }

  /** Names the moment in the address, once things have come to rest. */
  #name(): void {
    clearTimeout(this.#address);
    const { context } = this.opened;
    this.#address = window.setTimeout(() => {
      if (!context.signal.aborted) context.setQuery(this.#query());
    }, ADDRESS_MS);
  }

  #query(): URLSearchParams {
    const { index, context, sequence } = this.opened;
    const query = new URLSearchParams();
    const twin = context.query.get('twin') ?? '';
    if (twin !== '') query.set('twin', twin);
    if (index > 0) query.set('sequence', String(index));
    if (this.#clock.frame > 0) query.set('frame', String(this.#clock.frame));
    if (this.#camera > 0) query.set('camera', String(this.#camera));
    query.set('view', this.scene.stage.view);
    writeLook(this.look, query, sequence.motion.colors !== null);
    return query;
  }

  /** Opens the page with another sequence or twin. */
  #go(change: Readonly<Record<string, string>>): void {
    const query = this.#query();
    for (const [name, value] of Object.entries(change)) {
      if (value === '') query.delete(name);
      else query.set(name, value);
    }
    if ('sequence' in change) query.delete('view');
    this.opened.context.navigate(`#/captures/${this.opened.id}/playback?${query}`);
  }

  readonly #key = (event: KeyboardEvent): void => {
    const key = keyOf(event);
    if (key === null) return;
    event.preventDefault();
    if (key === 'toggle') this.#timeline.toggle();
    else this.#clock.step(key === 'on' ? 1 : -1);
  };
}
