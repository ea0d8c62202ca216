import { hasEnded, type Capture } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { problemBox } from '../../ui/problem';
import { faultPlace } from '../parts/actions';
import { hasPoints } from '../parts/ingest';
import { JobView, follow } from '../parts/job';
import { LabelEditor } from '../parts/labels';
import { fileActions, mainActions, type Masks } from './actions';
import { ingestAgain } from './reading/again';
import { CalibrationCard, inUse } from './reading/calibration';
import { firstImages } from './report/cameras';
import { factsCard } from './report/facts';
import { findingsView } from './report/findings';
import { picturesView } from './report/pictures';
import { concerns, type Finding, type Report } from './report/report';
import { fitsOf, twinsOf } from './results';
import { sourcesView } from './report/sources';
import { Supplements } from './reading/supplements';
import { timelineView } from './report/timeline_view';
import { verdictView } from './report/verdict';
import './captures.css';

/** The page of a capture: its report, what came of it, and what can be done with it. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const path = `/v1/captures/${id}`;
  const capture = await context.api.get('/v1/captures/{id}', { id, signal: context.signal });
  const page = new CapturePage(context, id, path, capture);
  void page.follow();
  return { element: page.element };
};

class CapturePage {
  readonly element: HTMLElement;
  readonly #job = new JobView('Reading of the recording');
  readonly #verdict = h('div');
  readonly #actions = h('div', { class: 'buttons' });
  readonly #faults = faultPlace();
  readonly #images = h('div');
  readonly #report = h('div');
  readonly #pictures = h('div');
  readonly #sources = h('div');
  readonly #calibration: CalibrationCard;
  readonly #supplements: Supplements;
  readonly #files = h('div', { class: 'buttons' });
  readonly #facts = h('div');
  #masks: Masks = null;
  /** Displayed state: what depends on it is redrawn only when it changes. */
  #state = '';

  constructor(
    private readonly context: PageContext,
    private readonly id: string,
    private readonly path: string,
    private capture: Capture,
  ) {
    const labels = new LabelEditor<Capture>(context, 'captures', path, capture, (changed) => this.update(changed));
    const started = (changed: Capture): void => {
      this.update(changed);
      void this.follow();
    };
    this.#calibration = new CalibrationCard(context, () => this.capture, started);
    this.#supplements = new Supplements(context, id, (changed) => this.update(changed), started);
    this.element = h(
      'div',
      {},
      this.#verdict,
      this.#job.element,
      this.#actions,
      this.#faults,
      labels.element,
      this.#images,
      this.#report,
      twinsOf(context, capture.name),
      fitsOf(context, capture.name),
      this.#pictures,
      h('h2', {}, 'Reading'),
      this.#sources,
      this.#calibration.element,
      this.#supplements.element,
      ingestAgain(context, path, () => this.capture, started),
      h('h2', {}, 'Files and facts'),
      this.#files,
      this.#facts,
    );
    this.update(capture);
  }

  /** Follows the ingest until it has ended. */
  async follow(): Promise<void> {
    if (hasEnded(this.capture.ingest)) return;
    await follow<Capture>(this.context, this.path, ({ ingest }) => ingest, (capture) => this.update(capture), this.#faults);
  }

  private update(capture: Capture): void {
    // An answer of before must not take the place of a later one.
    if (capture.ingest.revision < this.capture.ingest.revision) return;
    this.capture = capture;
    this.context.setTitle(capture.display_name || 'Capture without a name');
    this.#job.update(capture.ingest);
    const { state: word, revision } = capture.ingest;
    // One run may end as the one before did, with another report.
    const state = hasEnded(capture.ingest) ? `${word} ${revision}` : word;
    if (state === this.#state) return;
    if (this.#state !== '') this.context.announce(`Reading: ${capture.ingest.state.toLowerCase()}`);
    this.#state = state;
    // The verdict says how a reading ended, unless it failed although the recording is fit for it.
    const isTold = capture.ingest.state === 'SUCCEEDED' || (capture.ingest.state === 'FAILED' && capture.verdict === 'unusable');
    this.#job.element.hidden = isTold;
    this.#showActions();
    this.#files.replaceChildren(...fileActions(this.context, capture, this.#faults));
    this.#facts.replaceChildren(factsCard(capture, null));
    if (hasEnded(capture.ingest)) void this.showReport();
  }

  #showActions(): void {
    const cancel = async (): Promise<void> => {
      this.update(await this.context.api.send<Capture>('POST', `${this.path}/ingest/cancel`, {}, this.context.signal));
    };
    const actions = mainActions(this.context, this.capture, this.#masks, cancel, this.#faults);
    this.#actions.replaceChildren(...actions);
    this.#actions.hidden = actions.length === 0;
  }

  private async showImages({ kind, cameras, findings }: Report): Promise<void> {
    let images = null;
    try {
      if (kind === 'recording' && cameras.length > 0) images = await firstImages(this.context, this.id);
    } catch {
      // The report does not need them.
    }
    this.#images.replaceChildren(...(images === null ? [] : [images.element]));
    const lacksMasks = findings.some((finding) => concerns(finding, 'MASKS_MISSING'));
    const hasMasks = images?.hasMasks === true || (hasPoints(this.capture) && !lacksMasks);
    this.#masks = images?.canMark !== true ? null : hasMasks ? 'some' : 'none';
    this.#showActions();
  }

  /** What can be done about a finding here. */
  private remedy(finding: Finding): HTMLElement | null {
    if (concerns(finding, 'MASKS_MISSING')) {
      return h('p', {}, h('a', { class: 'button', href: `#/captures/${this.id}/masks` }, 'Mark the object and the hand'));
    }
    if (concerns(finding, 'NOT_CALIBRATED')) {
      return h('p', {}, h('button', { type: 'button', onclick: () => this.#calibration.focus() }, 'Calibrate with a board'));
    }
    if (finding.code === 'CAMERA_OFF' && inUse(this.capture).correct !== true) {
      return this.#calibration.button('Apply the correction', { correct: true });
    }
    if (finding.code === 'GROUND_OFFERED' && inUse(this.capture).ground !== 'detected') {
      return this.#calibration.button('Use the detected ground', { ground: 'detected' });
    }
    return null;
  }

  private async showReport(): Promise<void> {
    const { context, id, path } = this;
    this.#supplements.element.hidden = false;
    this.#supplements.show(this.capture);
    if (!this.capture.verdict) {
      this.#calibration.element.hidden = true;
      for (const place of [this.#verdict, this.#images, this.#report, this.#pictures, this.#sources]) place.replaceChildren();
      return;
    }
    try {
      const report = await context.api.json<Report>(`${path}/report`, { signal: context.signal });
      void this.showImages(report);
      const lacksPoses = report.findings.some((finding) => concerns(finding, 'NOT_CALIBRATED'));
      if (report.kind === 'recording') this.#calibration.show(report.calibration ?? null, lacksPoses);
      else {
        this.#calibration.element.hidden = true;
        // What could not be read may be a recording whose masks or calibration are to be replaced.
        this.#supplements.element.hidden = hasPoints(this.capture);
      }
      const playback = hasPoints(this.capture) ? `#/captures/${id}/playback` : null;
      const sources = sourcesView(report.sources);
      const views = [
        timelineView(context, report, playback),
        findingsView(report, (finding) => this.remedy(finding), playback),
      ];
      this.#verdict.replaceChildren(verdictView(report));
      this.#report.replaceChildren(...views.filter((view) => view !== null));
      this.#pictures.replaceChildren(picturesView(context, id));
      this.#sources.replaceChildren(...(sources === null ? [] : [sources]));
      this.#facts.replaceChildren(factsCard(this.capture, report));
    } catch (error) {
      if (!context.signal.aborted) this.#report.replaceChildren(problemBox(error, () => void this.showReport()));
    }
  }
}
