import { hasEnded, idOf, tookS, type Fit } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { badge } from '../../ui/badge';
import { confirm } from '../../ui/dialog';
import { h, type Child } from '../../ui/dom';
import { cli, empty } from '../../ui/empty';
import { counted, duration, millimetres, name, percent, time } from '../../ui/format';
import { list, totalOf } from '../../ui/list';
import { textOf } from '../../ui/problem';
import { refresh } from '../../ui/refresh';
import { placeholder, thumbnail } from '../../ui/thumbnail';
import { compareLink } from '../parts/compare';
import { ERROR_HELP, below, errorCell } from '../parts/error';
import { tagLinks } from '../parts/labels';
import { filters } from '../parts/query';
import { MultiSelection, type Selectable } from '../parts/selection';
import { cancelQuestion } from './cancel';
import './list.css';

/** What stands in the place of the error of a fit without a twin. */
const OF_TRAINING = 'Training: a fit without a twin has only its error on the frames that it is fitted to.';
/** Interval at which running fits are refreshed [ms]. */
const REFRESH_MS = 2000;

const STATES = {
  name: 'state',
  label: 'State',
  values: [
    ['', 'all'],
    ['QUEUED', 'queued'],
    ['RUNNING', 'running'],
    ['SUCCEEDED', 'succeeded'],
    ['FAILED', 'failed'],
    ['CANCELLED', 'cancelled'],
  ],
} as const;

/** The list of fits, with those that wait and run. */
export const open: OpenPage = (context) => {
  context.setTitle('Fits');
  let mayChange = false;
  const faults = h('div', { class: 'fault-place' });
  const selection: MultiSelection = new MultiSelection(context, {
    noun: 'fit',
    question: (rows) =>
      rows.length === 1
        ? { title: 'Delete this fit?', text: 'It goes to the trash, if this server has one. Its twin is kept.' }
        : {
            title: `Delete ${counted(rows.length, 'fit')}?`,
            text: 'They go to the trash, if this server has one. Their twins are kept.',
          },
    onChange: () => void fits.reload(),
    actions: (rows) =>
      rows.length === 0
        ? null
        : [compareLink('fits', rows.map((row) => idOf(row.name))), ' ', cancelButton(context, rows, faults, () => fits.reload())],
  });
  const shown = filters(context, [STATES], () => void fits.restart());
  const fits = list<Fit>(context, {
    caption: 'Fits',
    hidesCaption: true,
    noun: 'fit',
    filtered: shown.words,
    columns: [
      { header: 'Name', orderBy: 'name', cell: (fit) => nameCell(context, selection, fit) },
      { header: 'State', cell: stateOf },
      { header: 'Error', help: `${ERROR_HELP} ${OF_TRAINING}`, orderBy: 'error', isNumeric: true, cell: errorOf },
      { header: 'Took', isNumeric: true, cell: ({ job }) => duration(tookS(job)) },
      { header: 'Tags', cell: ({ tags }) => tagLinks('fits', tags) },
      { header: 'Created', orderBy: 'create_time', cell: ({ job }) => time(job.create_time) },
    ],
    load: async (page) => {
      const query = { ...page, ...shown.query() };
      const reply = await context.api.get('/v1/fits', { query, signal: context.signal });
      mayChange = reply.fits.some(({ job }) => !hasEnded(job));
      return { rows: reply.fits, next_page_token: reply.next_page_token, total_size: totalOf(reply) };
    },
    empty: () =>
      Object.keys(shown.query()).length > 0
        ? empty('No fit matches.')
        : empty(
            ['There are no fits yet. ', h('a', { href: '#/fits/new' }, 'Start one'), ', or from a terminal:'],
            cli('bendtwin fit start CAPTURE --watch'),
          ),
  });
  void refresh(context, REFRESH_MS, async () => (mayChange ? fits.reload() : undefined));
  const start = h('div', { class: 'buttons' }, h('a', { class: 'button primary', href: '#/fits/new' }, 'Start a fit'));
  return { element: h('div', {}, start, shown.element, fits.element, faults, selection.element) };
};

function nameCell({ api, signal }: PageContext, selection: MultiSelection, fit: Fit): HTMLElement {
  const picture = fit.twin ? thumbnail(api, `/v1/${fit.twin}/thumbnail`, '', signal) : placeholder();
  const link = h('a', { href: `#/fits/${idOf(fit.name)}` }, name(fit.display_name));
  return h('span', { class: 'fit-name' }, selection.box(fit), picture, link);
}

/** The error of the twin with its kind; of a fit that runs that of what it has so far. */
function errorOf({ job, error_m, measure }: Fit): Child {
  const now = job.progress?.error_m;
  if (typeof error_m === 'number' || typeof now !== 'number') return errorCell(error_m, measure);
  return [millimetres(now), below(hasEnded(job) ? 'training' : 'training, now')];
}

/** A button that cancels the selected fits that have not ended. */
function cancelButton(
  { api, signal, announce }: PageContext,
  rows: readonly Selectable[],
  faults: HTMLElement,
  reload: () => Promise<void>,
): HTMLButtonElement {
  const cancel = async (): Promise<void> => {
    if (!(await confirm(cancelQuestion(rows))) || signal.aborted) return;
    button.disabled = true;
    const sent = rows.map((row) =>
      api.send('POST', `/v1/${row.name}/cancel`, {}, signal).then(
        () => null,
        (error: unknown) => h('p', {}, h('bdi', {}, `${row.display_name || idOf(row.name)}: ${textOf(error)}`)),
      ),
    );
    const refused = (await Promise.all(sent)).filter((fault) => fault !== null);
    if (signal.aborted) return;
    button.disabled = false;
    announce(`${counted(rows.length - refused.length, 'fit')} asked to stop`);
    faults.replaceChildren(refused.length === 0 ? '' : h('div', { class: 'problem', role: 'alert' }, ...refused));
    await reload();
  };
  const button = h('button', { type: 'button', class: 'small', onclick: () => void cancel() }, 'Cancel');
  return button;
}

function stateOf({ job }: Fit): Child {
  if (job.state !== 'RUNNING') return badge(job.state);
  const eta = job.progress?.eta_s;
  const left = eta === null || eta === undefined ? '' : `, ${duration(eta)} left`;
  return [badge(job.state), ` ${percent(job.progress?.fraction ?? 0)}${left}`];
}
