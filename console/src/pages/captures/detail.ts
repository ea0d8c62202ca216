import { hasEnded, type Capture } from '../../api/types';
import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { size, time } from '../../ui/format';
import { problemBox } from '../../ui/problem';
import { actionButton, deleteButton, download, faultPlace } from '../parts/actions';
import { hasPoints } from '../parts/ingest';
import { JobView, follow } from '../parts/job';
import { LabelEditor } from '../parts/labels';
import { settingsView } from '../parts/settings_view';
import { ingestAgain } from './again';
import { CalibrationCard, inUse } from './calibration';
import { cameraImages } from './cameras';
import { findingsView } from './findings';
import { camerasView, factsView } from './measured';
import { picturesView } from './pictures';
import { concerns, type Finding, type Report } from './report';
import { fitsOf, twinsOf } from './results';
import { sourcesView } from './sources';
import { Supplements } from './supplements';

/** The page of a capture. */
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
  readonly #images = h('div');
  readonly #report = h('div');
  readonly #calibration: CalibrationCard;
  readonly #supplements: Supplements;
  readonly #actions = h('div', { class: 'buttons' });
  readonly #faults = faultPlace();
  readonly #settings = h('div');
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
      this.#actions,
      this.#faults,
      labels.element,
      this.#job.element,
      facts([
        ['Uploaded', time(capture.create_time)],
        ['Size', size(capture.size_bytes)],
        ['BLAKE3', h('code', {}, capture.digest.slice(0, 16), '…')],
      ]),
      this.#images,
      this.#report,
      fitsOf(context, capture.name),
      twinsOf(context, capture.name),
      h('h2', {}, 'More'),
      this.#calibration.element,
      this.#supplements.element,
      ingestAgain(context, path, () => this.capture, started),
      this.#settings,
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
    this.#actions.replaceChildren(...this.actions());
    this.#settings.replaceChildren(settingsView('Settings of the ingest', capture.ingest.settings));
    if (!hasEnded(capture.ingest)) return;
    void this.showReport();
  }

  private actions(): HTMLElement[] {
    const { context, id, path, capture } = this;
    const faults = this.#faults;
    const isRead = hasPoints(capture);
    // Masks alone are there: fits need points.
    const isMasked = capture.ingest.state === 'SUCCEEDED' && !isRead;
    const cancel = async (): Promise<void> => {
      this.update(await context.api.send<Capture>('POST', `${path}/ingest/cancel`, {}, context.signal));
    };
    const question = {
      title: 'Delete this capture?',
      text: 'It goes to the trash, if this server has one, with its observation and its report. Twins that were fitted to it are kept.',
    };
    return [
      ...(isRead ? [h('a', { class: 'button primary', href: `#/fits/new?capture=${id}` }, 'Start a fit')] : []),
      ...(isRead ? [h('a', { class: 'button', href: `#/captures/${id}/playback` }, 'Play back')] : []),
      ...(isMasked ? [h('a', { class: 'button primary', href: `#/captures/${id}/masks` }, 'Look at the masks, and use them')] : []),
      ...(hasEnded(capture.ingest) ? [] : [actionButton(context, 'Stop reading', faults, cancel)]),
      download(context, 'Download the recording', `${path}/content`, `${id}.zip`, faults),
      ...(isRead
        ? [download(context, 'Download the observation', `${path}/observation`, `${id}-observation.zip`, faults)]
        : []),
      ...(capture.masks ? [download(context, 'Download the masks', `${path}/masks`, `${id}-masks.zip`, faults)] : []),
      deleteButton(context, path, question, '#/captures', faults),
    ];
  }

  private async showImages({ kind, cameras }: Report): Promise<void> {
    if (kind !== 'recording' || cameras.length === 0) return this.#images.replaceChildren();
    try {
      const images = await cameraImages(this.context, this.id, this.capture);
      this.#images.replaceChildren(...(images === null ? [] : [images]));
    } catch {
      // The report does not need them.
      this.#images.replaceChildren();
    }
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
      this.#images.replaceChildren();
      return this.#report.replaceChildren();
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
      this.#report.replaceChildren(
        findingsView(report, (finding) => this.remedy(finding)),
        factsView(report),
        ...[sourcesView(report.sources), camerasView(report.cameras)].filter((view) => view !== null),
        picturesView(context, id),
        h(
          'p',
          {},
          download(context, 'Download the report as a page', `${path}/report.html`, `${id}-report.html`, this.#faults),
        ),
      );
    } catch (error) {
      if (!context.signal.aborted) this.#report.replaceChildren(problemBox(error, () => void this.showReport()));
    }
  }
}
