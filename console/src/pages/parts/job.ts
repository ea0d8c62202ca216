import { hasEnded, tookS, watch, type Fault, type Job } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { badge } from '../../ui/badge';
import { h } from '../../ui/dom';
import { progress } from '../../ui/form';
import { counted, duration, percent, time } from '../../ui/format';
import { problemBox } from '../../ui/problem';
import { prose } from './text';

/** Words for the stages of a job, and for the steps of an ingest. */
const STAGES: Record<string, string> = {
  ingest: 'Reading',
  search: 'Searching',
  refine: 'Refining',
  evaluate: 'Evaluating',
};

/** Words for an iteration of a stage. */
const ITERATIONS: Record<string, string> = { search: ' generation', refine: ' pass' };

/** Current activity of a job, in a sentence; empty when it has ended. `waits` says what it waits for, if that is known. */
export function stageText({ state, progress: at, cancel_requested, attempts }: Job, waits = ''): string {
  if (state === 'QUEUED' && waits !== '') return waits;
  if (state === 'QUEUED') return attempts > 0 ? 'Waits for a worker, to resume.' : 'Waits for a worker.';
  if (state !== 'RUNNING') return '';
  if (cancel_requested) return 'Stopping.';
  if (at === null || at === undefined) return 'Begins.';
  const stage = STAGES[at.stage] ?? at.stage;
  const variant = at.variant === '' ? '' : at.stage === 'ingest' ? `: ${at.variant}` : ` (${at.variant})`;
  const word = ITERATIONS[at.stage] ?? '';
  const step = at.iterations > 0 ? `,${word} ${at.iteration} of ${at.iterations}` : '';
  const left = at.eta_s === null || at.eta_s === undefined ? '' : `, about ${duration(at.eta_s)} left`;
  return `${stage}${variant}${step}${left}.`;
}

/** Progress of a job, live. Its elements stay while it changes. */
export class JobView {
  readonly element: HTMLElement;
  readonly #head = h('p', { class: 'job-head' });
  readonly #bar: HTMLProgressElement;
  readonly #text = h('p', {});
  readonly #faults = h('div');

  constructor(label: string) {
    this.#bar = progress(label, 0);
    this.element = h('section', { class: 'job', 'aria-label': label }, this.#head, this.#bar, this.#text, this.#faults);
  }

  /** `waits` says what a queued job waits for, if that is known. */
  update(job: Job, waits = ''): void {
    const fraction = job.progress?.fraction ?? 0;
    const took = tookS(job);
    this.#head.replaceChildren(
      badge(job.state),
      ...(job.state === 'RUNNING' ? [` ${percent(fraction)}`] : []),
      ...(took === null ? [] : [` took ${duration(took)}`]),
      ...(job.attempts > 1 ? [`, ${counted(job.attempts, 'attempt')}`] : []),
      ...(job.end_time ? [took === null ? ' ended ' : ', ended ', time(job.end_time)] : []),
    );
    this.#bar.hidden = hasEnded(job);
    this.#bar.value = fraction;
    const text = [stageText(job, waits), job.state === 'RUNNING' ? (job.progress?.note ?? '') : ''].join(' ').trim();
    if (this.#text.textContent !== text) this.#text.textContent = text;
    this.#text.hidden = text === '';
    this.#faults.replaceChildren(...faultBoxes(job));
  }
}

/** Follows the events of a resource, `path` in the API, until its job has ended; `faults` shows what interrupts it. */
export async function follow<T>(
  { api, signal }: PageContext,
  path: string,
  jobOf: (resource: T) => Job,
  update: (resource: T) => void,
  faults: HTMLElement,
): Promise<void> {
  try {
    const isLast = (resource: T): boolean => hasEnded(jobOf(resource));
    for await (const resource of watch<T>(api, `${path}/events`, { signal, isLast })) update(resource);
  } catch (error) {
    if (!signal.aborted) faults.replaceChildren(problemBox(error));
  }
}

/** Why a job failed, and why attempts before ended. */
function faultBoxes({ fault, attempt_faults }: Job): HTMLElement[] {
  const earlier =
    attempt_faults.length === 0
      ? []
      : [
          h(
            'details',
            { class: 'card' },
            h('summary', {}, `Why ${counted(attempt_faults.length, 'earlier attempt')} ended`),
            h('ol', {}, ...attempt_faults.map((own) => h('li', {}, ...faultText(own)))),
          ),
        ];
  if (fault === null || fault === undefined) return earlier;
  return [h('div', { class: 'problem', role: 'alert' }, h('p', {}, ...faultText(fault))), ...earlier];
}

function faultText({ reason, message }: Fault): (Node | string)[] {
  return [prose(message), ' ', h('code', {}, reason)];
}
