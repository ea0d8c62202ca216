import { idOf } from '../../api/routes';
import { hasEnded, type Fit, type Twin } from '../../api/types';
import type { PageContext } from '../../page';
import { badge } from '../../ui/badge';
import { h } from '../../ui/dom';
import { millimetres, name, percent, time } from '../../ui/format';
import { list } from '../../ui/list';
import { refresh } from '../../ui/refresh';

/** Rows that are shown of each [rows]. */
const MOST = 10;

/** The last fits of a capture. */
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
      { header: 'Error', isNumeric: true, cell: ({ error_m }) => millimetres(error_m) },
      { header: 'Created', cell: ({ job }) => time(job.create_time) },
    ],
    load: async ({ page_token }) => {
      const query = { capture, page_token, page_size: MOST };
      const { fits: rows, next_page_token } = await context.api.get('/v1/fits', { query, signal: context.signal });
      isRunning = rows.some(({ job }) => !hasEnded(job));
      return { rows, next_page_token };
    },
    empty: () => h('p', { class: 'muted' }, 'None yet.'),
  });
  void refresh(context, 2000, async () => (isRunning ? fits.reload() : undefined));
  return h('section', {}, h('h2', {}, 'Fits'), fits.element);
}

/** The last twins of a capture. */
export function twinsOf(context: PageContext, capture: string): HTMLElement {
  const id = idOf(capture);
  const twins = list<Twin>(context, {
    caption: 'Twins of this capture',
    hidesCaption: true,
    columns: [
      { header: 'Twin', cell: (twin) => h('a', { href: `#/twins/${idOf(twin.name)}` }, name(twin.display_name)) },
      { header: 'Error', isNumeric: true, cell: ({ error_m }) => millimetres(error_m) },
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
      const query = { capture, page_token, page_size: MOST };
      const { twins: rows, next_page_token } = await context.api.get('/v1/twins', { query, signal: context.signal });
      return { rows, next_page_token };
    },
    empty: () => h('p', { class: 'muted' }, 'None yet.'),
  });
  return h('section', {}, h('h2', {}, 'Twins'), twins.element);
}
