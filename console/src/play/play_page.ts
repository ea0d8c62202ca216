import { Vector3 } from 'three';
import type { Page, PageContext } from '../page';
import { visitedTwin } from '../api/visit';
import { h } from '../ui/dom';
import type { TwinShape } from '../view3d/shape';
import { Background } from './background/background';
import { Driver } from './input/driver';
import { GamepadDrive } from './input/gamepad';
import { GripperKeys } from './input/keys';
import type { Facts, Message, ProblemText, Ready, Text } from './protocol/messages';
import { beginOf, readMoment, writeMoment, type Moment } from './share/moment';
import { layoutOf } from './layout';
import { panelsOf, type Panels } from './panels';
import { PointerDrag } from './input/pointer';
import type { Playing } from './playing';
import { PlayScene } from './scene';
import { PlaySocket, type SocketListener } from './protocol/socket';
import type { PlayState } from './protocol/state';
import { StatusLine } from './status_line';
import { Trust } from './trust/trust';
import type { ShownTwin } from './twin';
import { WorldModel } from './world_model';
import './play.css';

/** Least time between two changes of the world that a slider sends [ms]. */
const WORLD_MS = 60;
/** Least time between two words of what was drawn [ms]. */
const SEEN_MS = 12;
/** Time that a text stays, and for each of its letters [ms]. */
const SAY_MS = 6000;
const SAY_LETTER_MS = 60;

/** The page of a play: what is seen, what moves it, and panels beside it. */
export class PlayPage implements Page, SocketListener {
  readonly element: HTMLElement;
  readonly #context: PageContext;
  readonly #scene: PlayScene;
  readonly #driver: Driver;
  readonly #model: WorldModel;
  readonly #keys: GripperKeys;
  readonly #gamepad: GamepadDrive;
  readonly #panels: Panels;
  readonly #trust: Trust;
  readonly #background: Background;
  readonly #status: StatusLine;
  readonly #hint = h('p', { class: 'play-hint' }, 'Drag the object or a gripper');
  readonly #overlay = h('p', { class: 'play-message', role: 'status' }, 'Opening…');
  readonly #said = h('p', { role: 'status', class: 'play-message' });
  readonly #watch = h('a', { hidden: true, target: '_blank' }, 'Watch this play in another window');
  readonly #shape: TwinShape;
  #socket: PlaySocket | null = null;
  #ready: Ready | null = null;
  #facts: Facts | null = null;
  #plays = false;
  #path = '';
  #adopts = true;
  #first: Partial<Moment>;
  #awaited: number | null = null;
  #seen = { sent: -1, at: 0 };
  #world: ReturnType<typeof setTimeout> | null = null;
  #silence: ReturnType<typeof setTimeout> | null = null;

  constructor(context: PageContext, twin: ShownTwin) {
    const { id, shape, name, capture } = twin;
    this.#context = context;
    this.#shape = shape;
    this.#status = new StatusLine((text) => context.announce(text));
    this.#first = readMoment(context.query, shape.rest.length / 3, shape.controls.length / 3);
    this.#trust = Trust.of(context.api, id, shape, capture, context.signal);
    const label = `The twin ${name}: arrows move the selected gripper, space grasps and releases`;
    this.#scene = new PlayScene(shape, label, this.#trust);
    const { stage, ground } = this.#scene;
    this.#background = Background.of({ stage, ground, shape }, context, capture);
    this.#driver = new Driver((message) => this.#send(message), 1.2 * shape.spacing);
    this.#model = new WorldModel(shape);
    this.#model.adopt(this.#first.world ?? {}, this.#first.vary ?? {});
    const playing: Playing = {
      context, scene: this.#scene, driver: this.#driver, model: this.#model, name,
      ready: () => this.#ready,
      send: (message) => this.#send(message),
      sendWorld: () => this.#sendWorld(),
      say: (text) => this.#say(text),
    };
    // The place of the camera comes first, so that a background may take it.
    if (!stage.setView(context.query.get('view') ?? '')) stage.lookAt(this.#first.positions ?? shape.rest);
    this.#panels = panelsOf(playing, { shape, background: this.#background }, () => this.#selected(), () => this.#query());
    stage.overlay.append(this.#hint, h('div', { class: 'play-messages' }, this.#said, this.#overlay));
    new PointerDrag(this.#scene, this.#driver, {
      isWatching: () => !this.#plays,
      setsGoal: () => this.#panels.goal.sets,
      keepsHold: () => this.#panels.keepsHold(),
      goalSet: (node) => this.#panels.goal.set(node),
      colliderMoved: (collider, to) => {
        this.#model.moveTo(collider, to.toArray());
        this.#driver.moveCollider(collider, to);
      },
      selected: () => this.#selected(),
    });
    this.#keys = new GripperKeys(this.#scene, this.#driver, () => this.#selected());
    this.#gamepad = new GamepadDrive(this.#scene, this.#driver, () => this.#selected(), context.signal);
    stage.beforeFrame((now) => this.#frame(now));
    const links = h('p', { class: 'row' }, this.#watch,
      h('a', { href: `#/twins/${id}/view` }, 'Look at its springs and triplets'));
    // Visitors have this page alone.
    links.hidden = visitedTwin() !== null;
    this.element = layoutOf({
      bar: this.#panels.bar,
      stage: stage.element,
      below: this.#status.element,
      panels: [this.#panels.column, links],
    });
  }

  /** Opens the socket of a play, or of one to watch. */
  connect(path: string, plays: boolean): void {
    this.#plays = plays;
    this.#path = path;
    if (!plays) {
      this.element.classList.add('is-watched');
      this.#panels.watchOnly();
      this.#hint.textContent = 'You are watching: drag to rotate the view';
    }
    this.#connect();
  }

  /** The first message: where the address says, or where it was when the connection was lost. */
  begin(): object | null {
    if (!this.#plays) return null;
    if (this.#scene.state === null) return beginOf(this.#first);
    return beginOf(this.#moment());
  }

  text(text: Exclude<Text, { type: 'ended' }>): void {
    if (text.type === 'ready') this.#begun(text);
    else if (text.type === 'facts') this.#know(text);
    else if (text.type === 'notice') this.#say(text.text);
    else {
      this.#adopts = true;
      this.#say(`Not done: ${text.problem.detail}`);
    }
  }

  state(state: PlayState): void {
    const newest = this.#driver.see(state);
    if (newest !== null) this.#awaited = newest;
    this.#scene.push(state);
    this.#status.warn(this.#trust.warning);
    this.#panels.refresh();
  }

  lost(): void {
    this.#show('The connection is lost: the play continues from here when the server is back.');
    this.#status.clear();
  }

  ended(problem: ProblemText | null): void {
    this.#show(`The play has ended. ${problem?.detail ?? ''}`);
    this.#status.clear();
    if (!this.#plays) {
      this.#hint.hidden = true;
      return;
    }
    const again = h('button', { type: 'button', class: 'small', onclick: () => this.#connect() }, 'Play on');
    this.#overlay.append(' ', again);
  }

  dispose(): void {
    for (const timer of [this.#world, this.#silence]) if (timer !== null) clearTimeout(timer);
    this.#scene.dispose();
  }

  #connect(): void {
    this.#show('Opening…');
    this.#socket = new PlaySocket(this.#path, this, this.#context.api.connection, this.#context.signal);
  }

  #begun(ready: Ready): void {
    const again = this.#ready !== null;
    this.#ready = ready;
    this.#adopts = true;
    this.#seen = { sent: -1, at: 0 };
    this.#scene.begin(ready);
    this.#driver.begin(ready);
    this.#overlay.hidden = true;
    this.#watch.setAttribute('href', `#/${ready.play}`);
    this.#watch.hidden = !this.#plays;
    if (again && this.#plays && this.#facts !== null) {
      if (this.#facts.paused) this.#send({ type: 'pause', paused: true });
      if (this.#facts.speed !== 1) this.#send({ type: 'speed', factor: this.#facts.speed });
      this.#say('The play continues from what you saw.');
    }
    this.#scene.stage.describe(this.#panels.describe(ready));
  }

  #know(facts: Facts): void {
    // A replay has a separate world, after which that of the play is back.
    const isOther = facts.replay !== null || (this.#facts !== null && this.#facts.replay !== null);
    this.#facts = facts;
    this.#scene.surround(facts);
    if (this.#adopts || !this.#plays || isOther) {
      this.#adopts = false;
      this.#model.adopt(facts.world, facts.vary);
    }
    this.#panels.update(facts);
    this.#status.update(facts, this.#scene);
  }

  /** Prepares a picture, and says afterwards that it was drawn. */
  #frame(now: number): boolean {
    const keys = this.#plays && this.#keys.frame(now);
    const pad = this.#plays && this.#gamepad.frame(now);
    this.#driver.flush();
    const moves = this.#scene.draw(now, this.#driver);
    const { state } = this.#scene;
    if (state !== null && state.number !== this.#seen.sent && performance.now() - this.#seen.at > SEEN_MS) {
      this.#seen = { sent: state.number, at: performance.now() };
      this.#send({ type: 'seen', frame: state.number });
    }
    if (this.#awaited !== null) {
      this.#status.acted(this.#awaited, this.#scene.stage);
      this.#awaited = null;
    }
    return moves || keys || pad || state?.number !== this.#seen.sent;
  }

  #send(message: Message): boolean {
    if (message.type !== 'seen' && !this.#plays) return false;
    if (message.type === 'grasp' || message.type === 'move') this.#hint.hidden = true;
    return this.#socket?.send(message) ?? false;
  }

  /** Sends the world; only the last of several successive changes. */
  #sendWorld(): void {
    this.#world ??= setTimeout(() => {
      this.#world = null;
      this.#send({ type: 'world', input: this.#driver.input, world: this.#model.world, vary: this.#model.vary });
    }, WORLD_MS);
  }

  #selected(): void {
    const { selected } = this.#driver;
    const isFree = !this.#driver.isHolding(selected) && !this.#driver.held.has(selected);
    // A pointer that was never used is out of sight.
    if (isFree && selected >= this.#driver.hands && this.#driver.placeOf(selected).lengthSq() === 0) {
      const near = this.#scene.controls.length > 2 ? new Vector3().fromArray(this.#scene.controls) : new Vector3();
      this.#driver.move(selected, this.#scene.node(this.#scene.nearest(near) ?? 0));
    }
    this.#panels.refresh();
    this.#scene.stage.invalidate();
  }

  /** The current moment, from which another play can begin. */
  #moment(): Moment {
    const { positions } = this.#scene.motion.shown;
    const hands = Array.from({ length: this.#driver.hands }, (_, g) => g);
    return {
      positions: positions.length > 0 ? positions : this.#shape.rest,
      controls: this.#scene.controls,
      dropped: hands.filter((g) => !this.#driver.isHolding(g)),
      world: this.#model.world,
      vary: this.#model.vary,
    };
  }

  #query(): URLSearchParams {
    const query = writeMoment(this.#moment());
    query.set('view', this.#scene.stage.view);
    if (this.#background.choice !== 'grid') query.set('background', this.#background.choice);
    return query;
  }

  #show(text: string): void {
    this.#overlay.textContent = text;
    this.#overlay.hidden = false;
  }

  /** Says something for as long as it takes to read it. */
  #say(text: string): void {
    this.#said.textContent = text;
    if (this.#silence !== null) clearTimeout(this.#silence);
    this.#silence = setTimeout(() => this.#said.replaceChildren(), SAY_MS + text.length * SAY_LETTER_MS);
  }
}
