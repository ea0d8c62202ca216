import { hasEnded, idOf, type Fit, type Twin } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { badge } from '../../ui/badge';
import { h } from '../../ui/dom';
import { name, percent, time } from '../../ui/format';
import { list } from '../../ui/list';
import { refresh } from '../../ui/refresh';
import { thumbnail } from '../../ui/thumbnail';
import { ERROR_HELP, errorCell } from '../parts/error';
import { twinErrorCell } from '../twins/quality';
import './named.css';

/** Rows of a page. */
const MOST = 10;

/** The fits of a capture, the best first. */
export function fitsOf(context: PageContext, capture: string): HTMLElement {
  let isRunning = false;
  const fits = list<Fit>(context, {
    caption: 'Fits of this capture',
    hidesCaption: true,
    columns: [
      { header: 'Fit', cell: (fit) => h('a', { href: `#/fits/${idOf(fit.name)}` }, name(fit.display_name)) },
      {
        header: 'State',
        cell: ({ job }) => [badge(job.state), job.state === 'RUNNING' && ` ${percent(job.progress?.fraction ?? 0)}`],
      },
      { header: 'Error', help: ERROR_HELP, isNumeric: true, cell: ({ error_m, measure }) => errorCell(error_m, measure) },
      { header: 'Created', cell: ({ job }) => time(job.create_time) },
    ],
    load: async ({ page_token }) => {
      const query = { capture, page_token, page_size: MOST, order_by: 'error' };
      const { fits: rows, next_page_token } = await context.api.get('/v1/fits', { query, signal: context.signal });
      isRunning = rows.some(({ job }) => !hasEnded(job));
      return { rows, next_page_token };
    },
    empty: () => h('p', { class: 'muted' }, 'None yet.'),
  });
  void refresh(context, 2000, async () => (isRunning ? fits.reload() : undefined));
  return h('section', {}, h('h2', {}, 'Fits'), fits.element);
}

/** The twins of a capture, the best first. */
export function twinsOf(context: PageContext, capture: string): HTMLElement {
  const id = idOf(capture);
  const twins = list<Twin>(context, {
    caption: 'Twins of this capture',
    hidesCaption: true,
    columns: [
      { header: 'Twin', cell: (twin) => twinCell(context, twin) },
      { header: 'Error', help: ERROR_HELP, isNumeric: true, cell: twinErrorCell },
      { header: 'Created', cell: ({ create_time }) => time(create_time) },
      {
        header: 'Beside the recording',
        cell: (twin) =>
          h(
            'a',
            {
              href: `#/captures/${id}/playback?twin=${idOf(twin.name)}`,
              'aria-label': `Play back with ${twin.display_name}`,
            },
            'Play back',
          ),
      },
    ],
    load: async ({ page_token }) => {
      const query = { capture, page_token, page_size: MOST, order_by: 'error' };
      const { twins: rows, next_page_token } = await context.api.get('/v1/twins', { query, signal: context.signal });
      return { rows, next_page_token };
    },
    empty: () => h('p', { class: 'muted' }, 'None yet.'),
  });
  return h('section', {}, h('h2', {}, 'Twins'), twins.element);
}

function twinCell({ api, signal }: PageContext, twin: Twin): HTMLElement {
  const link = h('a', { href: `#/twins/${idOf(twin.name)}` }, name(twin.display_name));
  return h('span', { class: 'capture-name' }, thumbnail(api, `/v1/${twin.name}/thumbnail`, '', signal), link);
}
