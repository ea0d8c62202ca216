import { hasEnded, Problem, type Capture } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../page';
import { findingList } from '../pages/captures/report/findings';
import { concerns, type Report } from '../pages/captures/report/report';
import { actionButton, download, faultPlace } from '../pages/parts/actions';
import { hasPoints, readAgain } from '../pages/parts/ingest';
import { JobView, follow } from '../pages/parts/job';
import { PlaybackFile } from '../playback/file/file';
import { hasSeveralRecordings } from '../playback/file/head';
import { h } from '../ui/dom';
import { problemBox } from '../ui/problem';
import { Tools } from './brushes';
import { Draft } from './drafts';
import { commandOf, focusOf } from './keys';
import { described } from './marking';
import { StrokeList } from './stroke_list';
import { MOST_STROKES, Strokes, readStrokes, type Stroke } from './strokes';
import { Workspace } from './workspace';
import '../play/play.css';
import '../playback/playback.css';
import './masks.css';

/** Time after the last change after which the address names the frame [ms]. */
const ADDRESS_MS = 300;

/** Marks in the images of a capture, and the masks that follow from them. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const capture = await context.api.get('/v1/captures/{id}', { id, signal: context.signal });
  const page = new MasksPage(context, id, capture);
  await page.load();
  void page.follow();
  return { element: page.element, dispose: () => page.dispose() };
};

class MasksPage {
  readonly element: HTMLElement;
  readonly #path: string;
  readonly #job = new JobView('Following');
  readonly #tools: Tools;
  readonly #strokes: Strokes;
  readonly #draft: Draft;
  readonly #place = h('div', { class: 'masks-place' });
  readonly #list = h('div', { class: 'masks-side' });
  readonly #actions = h('div', { class: 'buttons' });
  readonly #hint = h('p', { class: 'hint' });
  readonly #findings = h('section', { 'aria-label': 'Findings' });
  readonly #faults = faultPlace();
  #workspace: Workspace | null = null;
  #strokeList: StrokeList | null = null;
  #frame: number;
  #address = 0;
  /** The buttons that are shown, in words. */
  #buttons = '';
  /** Displayed state of the ingest: the images are loaded again when it ends. */
  #state: string;

  constructor(
    private readonly context: PageContext,
    private readonly id: string,
    private capture: Capture,
  ) {
    this.#path = `/v1/captures/${id}`;
    this.#state = capture.ingest.state;
    this.#frame = Number(context.query.get('frame') ?? 0);
    context.setTitle(`Masks of ${capture.display_name || 'a capture without a name'}`);
    this.#tools = new Tools({
      undo: () => this.#strokes.undo(),
      redo: () => this.#strokes.redo(),
      zoom: (factor) => this.#workspace?.zoom(factor),
      changed: () => this.#workspace?.redraw(),
    });
    this.#strokes = new Strokes(readStrokes(capture.ingest.settings), () => this.#changed());
    this.#draft = new Draft(id);
    const kept = this.#draft.get();
    if (kept !== null && this.#strokes.differFrom(kept)) this.#strokes.replace(kept);
    this.element = h(
      'div',
      { class: 'masks wide' },
      h('p', {},
        'Click the object once, and the hand once, in any camera: one click per thing in one camera is enough. ',
        'Depth carries it to the other cameras, and following carries it through time. ',
        h('a', { href: `#/captures/${id}` }, 'The capture')),
      this.#faults,
      h('div', { class: 'masks-columns' },
        this.#place,
        h('div', { class: 'masks-panel' },
          this.#tools.element,
          h('div', { class: 'masks-follow' }, this.#job.element, this.#actions, this.#hint, this.#findings),
          this.#list)),
      h('p', { class: 'hint', id: 'masks-keys' },
        'Click or drag to mark; with Alt held it marks background. Keys: 1, 2 and 3 choose the brush, arrows move the ',
        'cursor of an image that has the focus (with Shift by single pixels), Enter marks, Alt+Enter marks background, ',
        'Ctrl+Z undoes, plus and minus zoom, Space plays, comma and full stop step.'),
    );
    document.addEventListener('keydown', this.#key);
    context.signal.addEventListener('abort', () => clearTimeout(this.#address));
  }

  /** Loads the images, and the findings about their masks. */
  async load(): Promise<void> {
    const { context, id } = this;
    try {
      const file = await PlaybackFile.open(context.api, id, context.signal);
      const sequence = file.head.sequences[0];
      if (context.signal.aborted) return;
      this.#workspace?.dispose();
      this.#workspace = null;
      if (sequence === undefined || sequence.cameras.length === 0) {
        this.#explain('This capture has no images to mark: its points were tracked already.');
      } else if (hasSeveralRecordings(file.head)) {
        this.#explain('This capture has several recordings: send each by itself to mark it.');
      } else {
        this.#workspace = new Workspace(file, sequence, this.#frame, {
          context,
          tools: this.#tools,
          strokes: this.#strokes,
          mark: (stroke) => {
            const camera = this.#workspace?.names[stroke.camera] ?? '';
            if (this.#strokes.add(stroke)) context.announce(`Marked: ${described(stroke, camera)}`);
            else this.#fail(new Error(`There are ${MOST_STROKES} marks, the most that are possible: remove some.`));
          },
          fail: (error) => this.#fail(error),
          moved: (frame) => this.#name(frame),
        });
        this.#strokeList = new StrokeList(this.#strokes, this.#workspace.names, (stroke) => this.#workspace?.reveal(stroke));
        this.#tools.suit(Math.min(...sequence.cameras.map(({ size }) => size[0])));
        this.#place.replaceChildren(this.#workspace.element);
        this.#workspace.zoom(this.#tools.factor);
        this.#list.replaceChildren(this.#strokeList.element);
      }
      await this.#showFindings();
    } catch (error) {
      if (context.signal.aborted) return;
      if (!(error instanceof Problem && error.reason === 'PLAYBACK_MISSING')) throw error;
      this.#explain(
        hasEnded(this.capture.ingest)
          ? 'This capture has no images to mark: it could not be read so far, or was read by an older version. ' +
              'The page of the capture says why, and reads it again.'
          : 'The images come once the recording has been read.',
      );
    }
    this.#show();
  }

  /** Follows the ingest until it has ended. */
  async follow(): Promise<void> {
    if (hasEnded(this.capture.ingest)) return;
    await follow<Capture>(this.context, this.#path, ({ ingest }) => ingest, (capture) => this.#update(capture), this.#faults);
  }

  dispose(): void {
    document.removeEventListener('keydown', this.#key);
    this.#workspace?.dispose();
  }

  #update(capture: Capture): void {
    // An answer of before must not take the place of a later one.
    if (capture.ingest.revision < this.capture.ingest.revision) return;
    this.capture = capture;
    const { state } = capture.ingest;
    const hasChanged = state !== this.#state;
    this.#state = state;
    if (hasChanged) this.context.announce(`Following: ${state.toLowerCase()}`);
    this.#show();
    if (hasChanged && hasEnded(capture.ingest)) this.load().catch((error: unknown) => this.#fail(error));
  }

  /** Replaces the images by a sentence about their lack. */
  #explain(text: string): void {
    const link = h('a', { class: 'button', href: `#/captures/${this.id}` }, 'To the capture');
    this.#place.replaceChildren(h('div', { class: 'empty' }, h('p', {}, text), link));
    this.#list.replaceChildren();
  }

  #changed(): void {
    this.#draft.keep(this.#strokes.all);
    this.#show();
  }

  /** Shows strokes, the ingest, and what can be done next. */
  #show(): void {
    const { context, capture, id } = this;
    const path = this.#path;
    const isHere = this.#workspace !== null;
    const sent = readStrokes(capture.ingest.settings);
    const isNew = this.#strokes.differFrom(sent);
    const isUnderWay = !hasEnded(capture.ingest);
    const isRead = capture.ingest.state === 'SUCCEEDED';
    this.#tools.show(this.#strokes);
    this.#tools.element.hidden = !isHere;
    this.#strokeList?.show();
    this.#workspace?.showStrokes();
    this.#job.update(capture.ingest);
    // The page of the capture says how a reading ended that followed no marks.
    this.#job.element.hidden = !isUnderWay && sent.length === 0;
    const hasMasks = this.#workspace?.hasMasks ?? false;
    const canUse = isHere && !isUnderWay && isRead && hasMasks && !isNew && sent.length > 0 && !hasPoints(capture);
    const run = (until: 'masks' | 'points', strokes?: readonly Stroke[]) => async (): Promise<void> => {
      const next = await readAgain(context, this.capture, { until, strokes: strokes ?? this.#strokes.all });
      this.#draft.forget();
      if (until === 'points') return context.navigate(`#/captures/${id}`);
      this.#update(next);
      void this.follow();
    };
    const cancel = async (): Promise<void> => {
      this.#update(await context.api.send<Capture>('POST', `${path}/ingest/cancel`, {}, context.signal));
    };
    const word = hasMasks && sent.length > 0 ? 'Follow again' : 'Follow';
    const followButton = actionButton(context, word, this.#faults, run('masks'), canUse ? null : 'primary');
    followButton.disabled = !this.#strokes.has('object') || (!isNew && isRead && hasMasks);
    const buttons = [
      ...(isHere && !isUnderWay ? [followButton] : []),
      ...(canUse ? [actionButton(context, 'Use these masks', this.#faults, run('points'), 'primary')] : []),
      ...(sent.length > 0 && !isUnderWay
        ? [actionButton(context, 'Use the recorded masks', this.#faults, run('points', []))]
        : []),
      ...(isUnderWay ? [actionButton(context, 'Stop', this.#faults, cancel)] : []),
      ...(capture.masks ? [download(context, 'Download masks', `${path}/masks`, `${id}-masks.zip`, this.#faults)] : []),
    ];
    // Progress alone leaves the buttons: one that is replaced while it is pressed does nothing.
    const words = buttons.map(({ textContent, className }) => `${textContent} ${className}`).join() + followButton.disabled;
    if (words !== this.#buttons) this.#keepFocus(this.#actions, () => this.#actions.replaceChildren(...buttons));
    this.#buttons = words;
    this.#hint.textContent = isHere ? this.#hintText({ isNew, isUnderWay, canUse }) : '';
  }

  #hintText({ isNew, isUnderWay, canUse }: { isNew: boolean; isUnderWay: boolean; canUse: boolean }): string {
    if (isUnderWay) return 'You can add marks meanwhile, for the next time.';
    if (!this.#strokes.has('object')) return 'Mark the object first; then the hand, if one holds it.';
    if (canUse) {
      return (
        'Look at the masks along time, above all where they are doubtful. ' +
        'Mark what is wrong in any frame and follow again, or use them.'
      );
    }
    if (!isNew && hasPoints(this.capture)) return 'These masks are in use. Add marks to change them.';
    if (hasPoints(this.capture)) return 'The points of this capture go until new masks are used; twins stay.';
    return this.#strokes.has('hand') ? 'Following takes up to a second per frame.' : 'If a hand holds the object, mark it, too.';
  }

  /** Replaces buttons; the focus goes to the one with the same words, or to the first. */
  #keepFocus(buttons: HTMLElement, replace: () => void): void {
    const focused = document.activeElement;
    const had = focused instanceof HTMLElement && buttons.contains(focused) ? focused.textContent : null;
    replace();
    if (had === null) return;
    const all = [...buttons.querySelectorAll<HTMLElement>('button:not(:disabled), a')];
    (all.find(({ textContent }) => textContent === had) ?? all[0])?.focus();
  }

  /** What the last ingest found. */
  async #showFindings(): Promise<void> {
    const { context } = this;
    if (!this.capture.verdict) return this.#findings.replaceChildren();
    const report = await context.api.json<Report>(`${this.#path}/report`, { signal: context.signal });
    // What lacks before anything was marked is what this page is for, except for poses.
    const isFirst = readStrokes(this.capture.ingest.settings).length === 0;
    const findings = report.findings.filter((finding) => !isFirst || concerns(finding, 'NOT_CALIBRATED'));
    const toCapture = h('p', {}, h('a', { href: `#/captures/${this.id}` }, 'Calibrate on the page of the capture'));
    const list = findingList({ ...report, findings }, (finding) => (concerns(finding, 'NOT_CALIBRATED') ? toCapture : null));
    this.#findings.replaceChildren(...(list === null ? [] : [h('h2', {}, 'What was found'), list]));
  }

  #fail(error: unknown): void {
    if (!this.context.signal.aborted) this.#faults.replaceChildren(problemBox(error));
  }

  /** Names the frame in the address, once it has come to rest. */
  #name(frame: number): void {
    this.#frame = frame;
    clearTimeout(this.#address);
    this.#address = window.setTimeout(() => {
      this.context.setQuery(new URLSearchParams(frame === 0 ? {} : { frame: String(frame) }));
    }, ADDRESS_MS);
  }

  readonly #key = (event: KeyboardEvent): void => {
    const command = commandOf(event, focusOf(event.target));
    const workspace = this.#workspace;
    if (command === null || workspace === null) return;
    event.preventDefault();
    if (command === 'undo') this.#strokes.undo();
    else if (command === 'redo') this.#strokes.redo();
    else if (command === 'toggle') workspace.toggle();
    else if (command === 'back' || command === 'on') workspace.clock.step(command === 'on' ? 1 : -1);
    else if (command === 'larger' || command === 'smaller') this.#tools.zoomBy(command === 'larger' ? 1 : -1);
    else this.#tools.choose(command);
  };
}
