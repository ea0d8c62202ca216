import { idOf, type Twin } from '@bendtwin/client';
import type { PageContext } from '../page';
import { shareMenu } from '../play/share/menu';
import { h } from '../ui/dom';
import { counted } from '../ui/format';
import { problemBox } from '../ui/problem';
import { loadShape } from '../view3d/shape';
import type { TwinLayer } from '../view3d/twin_view';
import { Errors } from './axis/errors';
import { handSpeeds } from './axis/speed';
import { TimeAxis } from './axis/time_axis';
import { Cameras } from './camera/cameras';
import { NO_TWIN, firstTwin, sequenceChoice, twinChoice, twinsOf } from './choices';
import { Clock } from './clock';
import { loadExtent } from './extent';
import type { PlaybackFile } from './file/file';
import type { SequenceHead } from './file/head';
import { Motion, controlsOf } from './file/motion';
import { canEncode } from './film/encoder';
import { subjectOf, type Parts } from './film/subject';
import { videoButton, type Subject } from './film/video';
import { fullScreenButton } from '../ui/full_screen';
import { keyOf, keysText } from './keys';
import { readLook, writeLook } from './look';
import { lookControls } from './look_controls';
import { Player } from './player';
import { Prediction } from './prediction';
import { Scene } from './scene';
import { terms } from './terms';
import { Transport } from './transport';
import { worstButtons } from './worst/buttons';
import { note, worstOfAllButton } from './worst/all_sequences';

/** Time after the last change after which the address names the moment [ms]. */
const ADDRESS_MS = 300;

/** A sequence that is to be played. */
export interface Opened {
  readonly context: PageContext;
  readonly id: string;
  readonly name: string;
  readonly file: PlaybackFile;
  readonly index: number;
  readonly sequence: SequenceHead;
}

/** The page of one sequence: views beside each other above one time axis. */
export class PlaybackPage {
  readonly element: HTMLElement;
  readonly #clock: Clock;
  readonly #transport: Transport;
  readonly #axis: TimeAxis;
  readonly #worst = h('span', { class: 'row' });
  readonly #state = h('div', { role: 'status' });
  readonly #twinPlace = h('span');
  readonly #faults = h('div');
  #errors: Errors | null = null;
  /** The chosen twin; `NO_TWIN` if none was wanted, empty without one. */
  #twin: string;
  #twinName = '';
  #address = 0;
  #loading = -1;

  private constructor(
    private readonly opened: Opened,
    private readonly parts: Parts,
    /** Control points of all frames [m], shape [T, C, 3]. */
    controls: Float32Array,
  ) {
    const { context, sequence } = opened;
    const { scene } = parts;
    const { query } = context;
    this.#twin = query.get('twin') ?? '';
    this.#clock = new Clock(sequence.frame_count, sequence.fps, Number(query.get('frame') ?? 0), () => this.#changed());
    this.#transport = new Transport(this.#clock, sequence.train_frame_count, this.#worst);
    this.#axis = new TimeAxis(this.#clock, sequence.train_frame_count);
    this.#axis.setSpeeds(handSpeeds(controls, sequence.motion, sequence.fps));
    this.element = h('div', { class: 'playback wide' });
    this.#build();
    scene.stage.setView(query.get('view') ?? '');
    scene.stage.controls.addEventListener('end', () => this.#name());
    scene.stage.beforeFrame((now) => {
      this.#clock.tick(now, (frame) => this.#isHere(frame));
      return this.#clock.isPlaying;
    });
    context.signal.addEventListener('abort', () => clearTimeout(this.#address));
    document.addEventListener('keydown', this.#key);
    if (parts.cameras !== null) parts.cameras.changed = () => this.#changed();
    this.#changed();
    void this.#choose();
  }

  static async load(opened: Opened): Promise<PlaybackPage> {
    const { context, file, sequence, name } = opened;
    const read = file.read.bind(file);
    const motion = new Motion(sequence.motion, sequence.frame_count, read);
    const [colors, controls] = await Promise.all([
      sequence.motion.colors === null ? null : read(sequence.motion.colors),
      controlsOf(sequence.motion, read),
    ]);
    const extent = await loadExtent(motion, controls);
    const look = readLook(context.query, colors !== null);
    const scene = new Scene(sequence, extent, `Points of ${name}`);
    const camera = Number(context.query.get('camera'));
    const cameras = sequence.cameras.length === 0 ? null : new Cameras(sequence.cameras, read, camera);
    const player = new Player(motion, scene, cameras, colors, look);
    return new PlaybackPage(opened, { scene, player, look, cameras }, controls);
  }

  dispose(): void {
    document.removeEventListener('keydown', this.#key);
    this.#axis.dispose();
    this.parts.cameras?.dispose();
    this.parts.scene.dispose();
  }

  #build(): void {
    const { context, id, file, index, sequence, name } = this.opened;
    const { scene, look, cameras } = this.parts;
    const { motion } = sequence;
    const controls = lookControls(look, motion.colors !== null, () => {
      this.#showLayers();
      this.#changed();
    });
    const all = sequence.observed_points;
    const thinned = motion.point_count < all ? ` of ${counted(all, 'point')}` : '';
    const facts =
      `${counted(motion.point_count, 'point')}${thinned}, ${counted(motion.control_count, 'control point')}, ` +
      `${counted(sequence.frame_count, 'frame')} at ${Number(sequence.fps.toPrecision(4))} frames a second`;
    const keys = keysText(sequence.cameras.length);
    scene.stage.describe(`${facts}. ${keys}.`);
    const missed = file.head.left_out;
    const leftOut = missed > 0 ? ` For lack of space ${counted(missed, 'more sequence')} were left out.` : '';
    this.element.append(
      h('div', { class: 'row' },
        sequenceChoice(file.head, index, (other) => this.#go({ sequence: String(other), frame: '0' })),
        this.#twinPlace,
        h('a', { href: `#/captures/${id}` }, 'The capture'),
        controls,
        h('span', { class: 'playback-end' }, fullScreenButton(this.element))),
      this.#faults,
      h('div', { class: 'playback-views' }, scene.stage.element, cameras?.element),
      this.#transport.element,
      this.#axis.element,
      this.#state,
      h('p', { class: 'hint' }, `${facts}.${leftOut} Keys: ${keys}.`),
      terms(),
      // A browser that encodes no videos films the picture while it moves.
      shareMenu(scene.stage, context, () => this.#query(), name, canEncode() ? this.#video : undefined));
  }

  readonly #video = (say: (text: string) => void): HTMLElement => videoButton(() => this.#subject(), say);

  /** Offers twins, and predicts with the first one. */
  async #choose(): Promise<void> {
    const { context, id } = this.opened;
    const asked = context.query.get('twin');
    let twins: readonly Twin[] = [];
    try {
      twins = await twinsOf(context, id);
      this.#twin = firstTwin(asked, twins);
      this.#twinName = twins.find(({ name }) => idOf(name) === this.#twin)?.display_name ?? '';
      this.#twinPlace.replaceWith(twinChoice(twins, this.#twin, (twin) => this.#go({ twin })));
    } catch (error) {
      this.#fail(error);
    }
    if (this.#twin !== '' && this.#twin !== NO_TWIN) await this.#predict(this.#twin, asked === this.#twin);
  }

  /** Loads the prediction of a twin. */
  async #predict(twin: string, isAsked: boolean): Promise<void> {
    const { context, id, index, sequence } = this.opened;
    const { scene, player } = this.parts;
    const { api, signal } = context;
    this.#say('The twin is simulated beside the recording…');
    try {
      const [shape, prediction] = await Promise.all([
        loadShape(api, twin, signal), Prediction.load(api, { twin, capture: id, sequence: index }, signal),
      ]);
      if (signal.aborted) return;
      player.twin = { prediction, shape };
      scene.setTwin(shape, prediction.positions);
      const errors = (this.#errors = new Errors(prediction, sequence.frame_count));
      this.#transport.trainFrameCount = prediction.trainFrameCount;
      this.#axis.setErrors(errors, prediction.trainFrameCount);
      this.#offerWorst(twin, errors);
      this.#say(...prediction.warnings);
      this.element.classList.add('playback-predicted');
      this.#showLayers();
      this.#changed();
    } catch (error) {
      this.#say();
      // Nobody asked for the twin that is shown by itself.
      if (isAsked) this.#fail(error);
      else if (!signal.aborted) this.#say(`There is no prediction: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  /** Buttons that lead to the worst frames, of this sequence and of all. */
  #offerWorst(twin: string, errors: Errors): void {
    const { context, id, file, index, sequence } = this.opened;
    const { head, tag: version } = file;
    const show = (frame: number): void => {
      this.#clock.pause();
      this.#clock.seek(frame);
    };
    const isOne = head.sequences.length > 1;
    this.#worst.replaceChildren(...worstButtons(errors, sequence.fps, isOne, show));
    const predicted = { context, capture: id, twin, version, head };
    note(predicted, index, errors);
    if (!isOne || errors.main === null) return;
    this.#worst.append(worstOfAllButton(predicted, errors.main.of, (text) => this.#say(text), (found) => {
      if (found.sequence === index) show(found.frame);
      else this.#go({ twin, sequence: String(found.sequence), frame: String(found.frame) });
    }));
  }

  #showLayers(): void {
    const { look, scene, player } = this.parts;
    const layers = new Set<TwinLayer>();
    if (look.prediction) {
      layers.add(scene.layers.includes('skin') ? 'skin' : 'nodes');
      if (look.appearance) layers.add('appearance');
      if (look.springs) layers.add('springs');
    }
    scene.showTwin(layers, look.prediction && look.beside && player.twin !== null);
  }

  /** Draws what has changed, and loads what it lacks. */
  #changed(): void {
    const { frame, isPlaying } = this.#clock;
    this.#axis.show(this.#transport.show());
    this.parts.player.draw(frame);
    this.#isHere(frame);
    if (isPlaying) this.parts.scene.stage.invalidate();
    else this.#name();
  }

  /** True if a frame can be drawn; it is loaded otherwise. */
  #isHere(frame: number): boolean {
    const { player, scene } = this.parts;
    if (player.has(frame)) {
      // What follows is loaded before it is needed.
      if (this.#clock.isPlaying) void player.load(frame).catch(() => undefined);
      return true;
    }
    if (this.#loading === frame) return false;
    this.#loading = frame;
    player.load(frame).then(
      () => {
        if (this.#loading === frame) this.#loading = -1;
        player.draw(this.#clock.frame);
        scene.stage.invalidate();
      },
      (error: unknown) => {
        this.#loading = -1;
        this.#clock.pause();
        this.#fail(error);
      },
    );
    return false;
  }

  /** What a video is made of now. */
  #subject(): Subject {
    const { context, name } = this.opened;
    const { trainFrameCount } = this.#transport;
    return subjectOf(this.parts, this.#clock, {
      name, signal: context.signal, twin: this.#twinName, errors: this.#errors?.main?.values ?? [], trainFrameCount,
    });
  }

  #say(...texts: string[]): void {
    this.#state.replaceChildren(...texts.map((text) => h('p', { class: 'hint' }, text)));
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
    const { index } = this.opened;
    const { scene, look, cameras } = this.parts;
    const query = new URLSearchParams();
    if (this.#twin !== '') query.set('twin', this.#twin);
    if (index > 0) query.set('sequence', String(index));
    if (this.#clock.frame > 0) query.set('frame', String(this.#clock.frame));
    if (cameras !== null && cameras.chosen > 0) query.set('camera', String(cameras.chosen));
    if (scene.view !== null) query.set('view', scene.view);
    writeLook(look, query);
    return query;
  }

  /** Opens the page with another sequence or twin. */
  #go(change: Readonly<Record<string, string>>): void {
    const query = this.#query();
    for (const [name, value] of Object.entries(change)) query.set(name, value);
    if ('sequence' in change) query.delete('view');
    this.opened.context.navigate(`#/captures/${this.opened.id}/playback?${query}`);
  }

  readonly #key = (event: KeyboardEvent): void => {
    const key = keyOf(event);
    if (key === null) return;
    event.preventDefault();
    if (key === 'toggle') this.#transport.toggle();
    else if (typeof key === 'number') this.parts.cameras?.choose(key);
    else this.#clock.step(key === 'on' ? 1 : -1);
  };
}
