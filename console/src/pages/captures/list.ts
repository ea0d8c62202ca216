import { idOf } from '../../api/routes';
import { hasEnded, type Capture } from '../../api/types';
import type { OpenPage } from '../../page';
import { badge } from '../../ui/badge';
import { h, type Child } from '../../ui/dom';
import { cli, empty } from '../../ui/empty';
import { name, percent, size, time } from '../../ui/format';
import { list } from '../../ui/list';
import { refresh } from '../../ui/refresh';
import { tagLinks } from '../parts/labels';
import { hasPoints } from '../parts/ingest';
import { filters } from '../parts/query';

/** Interval at which captures that are being read are refreshed [ms]. */
const REFRESH_MS = 2000;

/** The list of captures. */
export const open: OpenPage = (context) => {
  context.setTitle('Captures');
  let isReading = false;
  const shown = filters(context, [], () => void captures.restart());
  const captures = list<Capture>(context, {
    caption: 'Captures',
    hidesCaption: true,
    columns: [
      {
        header: 'Name',
        orderBy: 'name',
        cell: (c) => h('a', { href: `#/captures/${idOf(c.name)}` }, name(c.display_name)),
      },
      { header: 'State', cell: stateOf },
      { header: 'Tags', cell: ({ tags }) => tagLinks('captures', tags) },
      { header: 'Size', isNumeric: true, cell: ({ size_bytes }) => size(size_bytes) },
      { header: 'Uploaded', orderBy: 'create_time', cell: ({ create_time }) => time(create_time) },
      { header: 'Fit', cell: fitLink },
    ],
    load: async (page) => {
      const query = { ...page, ...shown.query() };
      const { captures: rows, next_page_token } = await context.api.get('/v1/captures', {
        query,
        signal: context.signal,
      });
      isReading = rows.some(({ ingest }) => !hasEnded(ingest));
      return { rows, next_page_token };
    },
    empty: () =>
      Object.keys(shown.query()).length > 0
        ? empty('No capture has this text and tag.')
        : empty(
            [
              'There are no captures yet. Drop a recording on this page, ',
              h('a', { href: '#/upload' }, 'upload one'),
              ', or make one:',
            ],
            `bendtwin capture make rope && ${cli('bendtwin capture push rope.zip')}`,
          ),
  });
  void refresh(context, REFRESH_MS, async () => (isReading ? captures.reload() : undefined));
  const upload = h('div', { class: 'buttons' }, h('a', { class: 'button primary', href: '#/upload' }, 'Upload'));
  return { element: h('div', {}, upload, shown.element, captures.element) };
};

/** The verdict, or how far the reading of it is. */
function stateOf(capture: Capture): Child {
  const { ingest, verdict } = capture;
  if (ingest.state === 'RUNNING') return [badge('reading', 'busy'), ` ${percent(ingest.progress?.fraction ?? 0)}`];
  if (ingest.state === 'QUEUED') return badge('waits', 'neutral');
  if (ingest.state === 'SUCCEEDED' && !hasPoints(capture)) return badge('masks made', 'warn');
  if (verdict) return [badge(verdict), ingest.state === 'FAILED' && [' ', badge('not read', 'bad')]];
  return badge(ingest.state);
}

function fitLink(capture: Capture): Child {
  if (capture.verdict === 'unusable' || capture.ingest.state === 'FAILED') return '';
  if (capture.ingest.settings['until'] === 'masks') return '';
  const query = new URLSearchParams({ capture: idOf(capture.name) });
  return h('a', { href: `#/fits/new?${query}`, 'aria-label': `Fit ${capture.display_name}` }, 'Fit');
}
