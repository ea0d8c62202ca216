import { idOf } from '../../api/routes';
import { hasEnded, tookS, type Fit } from '../../api/types';
import type { OpenPage } from '../../page';
import { badge } from '../../ui/badge';
import { h, type Child } from '../../ui/dom';
import { cli, empty } from '../../ui/empty';
import { duration, millimetres, name, percent, time } from '../../ui/format';
import { list } from '../../ui/list';
import { refresh } from '../../ui/refresh';
import { Selection } from '../parts/compare';
import { tagLinks } from '../parts/labels';
import { filters } from '../parts/query';

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
  const selection = new Selection('fits');
  const shown = filters(context, [STATES], () => void fits.restart());
  const fits = list<Fit>(context, {
    caption: 'Fits',
    hidesCaption: true,
    columns: [
      {
        header: 'Name',
        orderBy: 'name',
        cell: (fit) => h('a', { href: `#/fits/${idOf(fit.name)}` }, name(fit.display_name)),
      },
      { header: 'State', cell: stateOf },
      { header: 'Error', orderBy: 'error', isNumeric: true, cell: ({ error_m }) => millimetres(error_m) },
      { header: 'Took', isNumeric: true, cell: ({ job }) => duration(tookS(job)) },
      { header: 'Tags', cell: ({ tags }) => tagLinks('fits', tags) },
      { header: 'Created', orderBy: 'create_time', cell: ({ job }) => time(job.create_time) },
      { header: 'Compare', cell: (fit) => selection.box(idOf(fit.name), fit.display_name) },
    ],
    load: async (page) => {
      const query = { ...page, ...shown.query() };
      const { fits: rows, next_page_token } = await context.api.get('/v1/fits', { query, signal: context.signal });
      mayChange = rows.some(({ job }) => !hasEnded(job));
      return { rows, next_page_token };
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
  const start = h(
    'div',
    { class: 'buttons' },
    h('a', { class: 'button primary', href: '#/fits/new' }, 'Start a fit'),
    selection.button,
  );
  return { element: h('div', {}, start, shown.element, fits.element) };
};

function stateOf({ job }: Fit): Child {
  if (job.state !== 'RUNNING') return badge(job.state);
  const eta = job.progress?.eta_s;
  const left = eta === null || eta === undefined ? '' : `, ${duration(eta)} left`;
  return [badge(job.state), ` ${percent(job.progress?.fraction ?? 0)}${left}`];
}
