import type { Fit, Twin } from '@bendtwin/client';
import { h } from '../../ui/dom';
import type { Child } from '../../ui/dom';
import { badge } from '../../ui/badge';
import { name, percent, time } from '../../ui/format';
import { table } from '../../ui/table';
import type { Column } from '../../ui/table';
import type { PageContext } from '../../page';
import { thumbnail } from '../../ui/thumbnail';
import { ERROR_HELP, errorCell } from '../parts/error';
import { levelBadge } from '../twins/verdict/level';
import type { Quality } from '../twins/quality';
import { errorText } from '../twins/verdict/reasons';
import type { Numbers } from './numbers';

/** The newest captures, fits and twins. Lists without rows are left out. */
export function newest(context: PageContext, numbers: Numbers): HTMLElement {
  return h(
    'div',
    {},
    twinCards(context, numbers.newestTwins),
    h(
      'div',
      { class: 'home-lists' },
      section('Newest fits', numbers.newestFits, [
        named((fit) => fit),
        { header: 'State', cell: stateOf },
        { header: 'Error', help: ERROR_HELP, isNumeric: true, cell: ({ error_m, measure }) => errorCell(error_m, measure) },
        made((fit) => fit.job.create_time),
      ]),
      section('Newest captures', numbers.newestCaptures, [
        named((capture) => capture),
        { header: 'State', cell: ({ verdict, ingest }) => badge(verdict ?? ingest.state) },
        made((capture) => capture.create_time),
      ]),
    ),
  );
}

/** The newest twins as cards: picture, name, verdict, error. */
function twinCards({ api, signal }: PageContext, twins: readonly Twin[]): Child {
  if (twins.length === 0) return null;
  const card = (twin: Twin): HTMLElement => {
    const quality = twin.quality as Quality;
    return h(
      'li',
      { class: 'card twin-card' },
      thumbnail(api, `/v1/${twin.name}/thumbnail?width=480`, '', signal),
      h('a', { class: 'twin-card-name', href: `#/${twin.name}` }, name(twin.display_name)),
      h('p', { class: 'row' }, levelBadge(quality.assessment?.level), h('span', {}, errorText(quality))),
      h('p', { class: 'row muted' }, time(twin.create_time), h('a', { class: 'button small', href: `#/${twin.name}/play`, 'aria-label': playLabel(twin) }, 'Play')),
    );
  };
  return h(
    'section',
    { 'aria-label': 'Newest twins' },
    h('div', { class: 'home-title' }, h('h2', {}, 'Newest twins'), h('a', { href: '#/twins' }, 'All twins')),
    h('ul', { class: 'cards twin-cards' }, ...twins.map(card)),
  );
}

function section<Row>(title: string, rows: readonly Row[], columns: readonly Column<Row>[]): Child {
  if (rows.length === 0) return null;
  return h('section', {}, h('h2', {}, title), table({ caption: title, hidesCaption: true, columns, rows }));
}

/** The name of a resource, as a link to its page. */
function named<Row>(of: (row: Row) => { name: string; display_name: string }): Column<Row> {
  return { header: 'Name', cell: (row) => h('a', { href: `#/${of(row).name}` }, name(of(row).display_name)) };
}

function made<Row>(of: (row: Row) => string): Column<Row> {
  return { header: 'Created', cell: (row) => time(of(row)) };
}

function stateOf({ job }: Fit): Child {
  const share = job.state === 'RUNNING' && job.progress ? ` ${percent(job.progress.fraction)}` : null;
  return [badge(job.state), share];
}

function playLabel(twin: { display_name: string }): string {
  return `Play with ${twin.display_name || 'this twin'}`;
}
