import { idOf, Problem, type Capture, type Fit, type Worker } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { field } from '../../ui/form';
import { problemBox } from '../../ui/problem';
import { findCapture } from '../parts/capture';
import { ANY_WORKER } from '../parts/requirements';
import { faultsByName } from '../parts/settings';
import { CaptureChoice } from './capture_choice';
import { SettingsForm } from './form';
import { formOf, settingsOf, withMoreStarts, withNodes, type FitForm } from './request';
import { WorkerForm } from './worker_form';

/**
 * The form that starts a fit: `?capture=` says of what, `?like=` the fit whose settings it begins with, `?from=` the
 * twin that it refines, `?starts=more` and `?nodes=800` what advice wants to be changed.
 */
export const open: OpenPage = async (context) => {
  context.setTitle('Start a fit');
  const [like, asked] = [context.query.get('like'), context.query.get('capture')];
  // One that was deleted leaves the choice open.
  const [{ workers }, model, given] = await Promise.all([
    context.api.get('/v1/workers', { signal: context.signal }),
    like === null ? null : fitOf(context, like),
    asked === null ? null : findCapture(context, `captures/${asked}`),
  ]);
  const capture = asked === null && model !== null ? await findCapture(context, model.capture) : given;
  return { element: new NewFit(context, workers, capture, model).element };
};

class NewFit {
  readonly element: HTMLFormElement;
  readonly #capture: CaptureChoice;
  readonly #name = h('input', { maxlength: '200', placeholder: 'that of the capture' });
  readonly #priority = h('input', { inputmode: 'numeric', placeholder: '0' });
  readonly #settings: SettingsForm;
  readonly #worker: WorkerForm;
  readonly #faults = h('div');
  readonly #submit = h('button', { type: 'submit', class: 'primary' }, 'Start the fit');
  /** Makes a repeated request the same one, as after an answer was lost. */
  #key = newKey();

  constructor(
    private readonly context: PageContext,
    workers: readonly Worker[],
    capture: Capture | null,
    model: Fit | null,
  ) {
    const form = asked(formOf(model?.job.settings ?? {}), context.query);
    const from = context.query.get('from');
    const refined: FitForm['others'] = from === null ? [] : [['start_from', `twins/${from}`]];
    this.#settings = new SettingsForm({ ...form, others: [...form.others, ...refined] });
    this.#worker = new WorkerForm(workers, model?.requirements ?? ANY_WORKER);
    this.#capture = new CaptureChoice(context, capture, () => (this.#key = newKey()));
    const hint = '-100 to 100; higher priorities run earlier.';
    this.element = h(
      'form',
      { onsubmit: (event) => void this.submit(event) },
      this.#capture.element,
      field('Name', this.#name),
      this.#settings.element,
      this.#worker.element,
      h('details', { class: 'card' }, h('summary', {}, 'Order in the queue'), field('Priority', this.#priority, hint)),
      this.#faults,
      h('div', { class: 'buttons' }, this.#submit),
    );
    // Another content under the same key would be refused.
    this.element.addEventListener('input', () => (this.#key = newKey()));
  }

  private async submit(event: Event): Promise<void> {
    event.preventDefault();
    const { context } = this;
    const { settings, faults } = settingsOf(this.#settings.value);
    if (this.tell(faults)) return;
    const requirements = this.#worker.value;
    if (requirements === null) return this.#worker.focus();
    this.#submit.disabled = true;
    try {
      const body = {
        capture: this.#capture.value,
        settings,
        display_name: this.#name.value.trim(),
        priority: Number(this.#priority.value) || 0,
        requirements,
      };
      const fit = await context.api.json<Fit>('/v1/fits', {
        method: 'POST',
        headers: { 'content-type': 'application/json', 'idempotency-key': this.#key },
        body: JSON.stringify(body),
        signal: context.signal,
      });
      context.navigate(`#/fits/${idOf(fit.name)}`);
    } catch (error) {
      if (context.signal.aborted) return;
      const isAboutSettings = error instanceof Problem && error.reason === 'INVALID_SETTINGS';
      if (!isAboutSettings) this.#faults.replaceChildren(problemBox(error));
      else this.tell(faultsByName(error.message));
    }
    this.#submit.disabled = false;
  }

  /** Shows faults at their fields, others below; false without faults. */
  private tell(faults: ReadonlyMap<string, string>): boolean {
    const rest = this.#settings.show(faults);
    this.#faults.replaceChildren(...(rest.length > 0 ? [problemBox(new Error(rest.join('; ')))] : []));
    if (faults.size > 0) this.context.announce(`${faults.size} settings are not accepted`);
    return faults.size > 0;
  }
}

/** A form with what the address asks to be changed. */
function asked(form: FitForm, query: URLSearchParams): FitForm {
  const started = query.get('starts') === 'more' ? withMoreStarts(form) : form;
  const nodes = Number(query.get('nodes'));
  return Number.isSafeInteger(nodes) && nodes > 0 ? withNodes(started, nodes) : started;
}

function fitOf({ api, signal }: PageContext, id: string): Promise<Fit> {
  return api.get('/v1/fits/{id}', { id, signal });
}

function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return `console-${[...bytes].map((byte) => byte.toString(16).padStart(2, '0')).join('')}`;
}
