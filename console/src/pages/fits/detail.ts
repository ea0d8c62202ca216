import { hasEnded, idOf, Problem, type Capture, type Fit } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { confirm } from '../../ui/dialog';
import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { time } from '../../ui/format';
import { problemBox } from '../../ui/problem';
import { actionButton, deleteButton, faultPlace } from '../parts/actions';
import { captureText, findCapture } from '../parts/capture';
import { JobView, follow } from '../parts/job';
import { LabelEditor } from '../parts/labels';
import { wanted } from '../parts/requirements';
import { settingsView } from '../parts/settings_view';
import { assessmentView, qualityView } from '../twins/assessment';
import { parametersView } from '../twins/parameters';
import type { Quality } from '../twins/quality';
import { LossView } from './curves';
import { FitPicture } from './picture/picture';
import { cancelQuestion } from './cancel';
import { whyItWaits } from './waiting';

/** The page of a fit: what it has so far or its twin, how far it is, its errors and losses, and what came of it. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const path = `/v1/fits/${encodeURIComponent(id)}`;
  const fit = await context.api.get('/v1/fits/{id}', { id, signal: context.signal });
  const page = new FitPage(context, path, fit, await findCapture(context, fit.capture));
  void page.follow();
  return { element: page.element, dispose: () => page.dispose() };
};

class FitPage {
  readonly element: HTMLElement;
  readonly #job = new JobView('Fit');
  readonly #picture: FitPicture;
  readonly #losses: LossView;
  readonly #actions = h('div', { class: 'buttons' });
  readonly #faults = faultPlace();
  readonly #result = h('div');
  /** What it waits for while it is queued. */
  #waits = '';
  /** Displayed state: what depends on it is redrawn only when it changes. */
  #state = '';

  constructor(
    private readonly context: PageContext,
    private readonly path: string,
    private fit: Fit,
    private readonly capture: Capture | null,
  ) {
    this.#losses = new LossView(context, idOf(fit.name));
    this.#picture = new FitPicture(context, (metres) => (this.#losses.baseline = metres));
    const labels = new LabelEditor<Fit>(context, 'fits', path, fit, (changed) => this.update(changed));
    this.element = h(
      'div',
      {},
      this.#actions,
      this.#faults,
      this.#picture.element,
      this.#job.element,
      this.#losses.errors,
      labels.element,
      facts([
        ['Capture', captureText(capture)],
        ['Asked for', time(fit.job.create_time)],
        ['Priority', fit.priority],
        ['Worker', wanted(fit.requirements)],
      ]),
      this.#result,
      this.#losses.element,
      // With a twin its file has the settings, and what was chosen for open ones.
      fit.twin ? '' : settingsView('Settings', fit.job.settings),
    );
    this.update(fit);
  }

  dispose(): void {
    this.#picture.dispose();
    this.#losses.dispose();
  }

  /** Follows the fit until it has ended. */
  async follow(): Promise<void> {
    if (hasEnded(this.fit.job)) return;
    await follow<Fit>(this.context, this.path, ({ job }) => job, (fit) => this.update(fit), this.#faults);
  }

  private update(fit: Fit): void {
    // An answer of before must not take the place of a later one.
    if (fit.job.revision < this.fit.job.revision) return;
    this.fit = fit;
    this.context.setTitle(fit.display_name || 'Fit without a name');
    this.#job.update(fit.job, this.#waits);
    this.#picture.update(fit);
    void this.#losses.update(hasEnded(fit.job));
    const state = `${fit.job.state} ${fit.job.cancel_requested} ${fit.twin ?? ''}`;
    if (state === this.#state) return;
    if (this.#state !== '') this.context.announce(`The fit is ${fit.job.state.toLowerCase()}`);
    this.#state = state;
    this.#actions.replaceChildren(...this.actions());
    if (fit.job.state === 'QUEUED') void this.explain(fit);
    if (fit.twin) void this.showResult(fit.twin);
  }

  /** Says what a queued fit waits for. */
  private async explain(fit: Fit): Promise<void> {
    const { api, signal } = this.context;
    try {
      const { workers } = await api.get('/v1/workers', { signal });
      this.#waits = whyItWaits(fit, this.capture, workers);
      this.#job.update(this.fit.job, this.#waits);
    } catch {
      // That it waits is said in any case.
    }
  }

  private actions(): HTMLElement[] {
    const { context, path, fit } = this;
    const faults = this.#faults;
    const cancel = async (): Promise<void> => {
      if (!(await confirm(cancelQuestion([fit])))) return;
      this.update(await context.api.send<Fit>('POST', `${path}/cancel`, {}, context.signal));
    };
    const id = fit.twin ? idOf(fit.twin) : '';
    const toTwin = [
      h('a', { class: 'button primary', href: `#/twins/${id}/play` }, 'Play with the twin'),
      h('a', { class: 'button', href: `#/twins/${id}` }, 'Open the twin'),
      ...(this.capture === null
        ? []
        : [h('a', { class: 'button', href: `#/${fit.capture}/playback?twin=${id}` }, 'Beside the recording')]),
    ];
    const own = this.capture === null ? {} : { capture: idOf(fit.capture) };
    const question = { title: 'Delete this fit?', text: 'It goes to the trash, if this server has one. Its twin is kept.' };
    return [
      ...(fit.twin ? toTwin : []),
      ...(hasEnded(fit.job) || fit.job.cancel_requested
        ? []
        : [actionButton(context, 'Cancel the fit', faults, cancel)]),
      h(
        'a',
        {
          class: 'button',
          href: `#/fits/new?${new URLSearchParams({ ...own, like: idOf(fit.name) })}`,
        },
        'Fit again with changes',
      ),
      ...(fit.job.state === 'RUNNING' ? [] : [deleteButton(context, path, question, '#/fits', faults)]),
    ];
  }

  private async showResult(twin: string): Promise<void> {
    const { context } = this;
    try {
      const { quality } = await context.api.get('/v1/twins/{id}', { id: idOf(twin), signal: context.signal });
      const asked = (): Promise<unknown> => Promise.resolve(this.fit.job.settings);
      this.#result.replaceChildren(
        ...[assessmentView(quality as Quality, toWhy(twin)), qualityView(quality as Quality)].filter((view) => view !== null),
        parametersView(context, idOf(twin), asked),
      );
    } catch (error) {
      if (context.signal.aborted) return;
      const isGone = error instanceof Problem && error.status === 404;
      const box = isGone
        ? h('p', { class: 'muted' }, 'Its twin was deleted.')
        : problemBox(error, () => void this.showResult(twin));
      this.#result.replaceChildren(box);
    }
  }
}

/** The way to what a verdict is due to, and what to do about it. */
function toWhy(twin: string): HTMLElement {
  return h('p', {}, h('a', { href: `#/${twin}` }, 'Why this verdict, and what to do next'));
}
