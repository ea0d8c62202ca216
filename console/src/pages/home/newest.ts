import { h } from '../../ui/dom';
import type { Child } from '../../ui/dom';
import { badge } from '../../ui/badge';
import { millimetres, name, percent, time } from '../../ui/format';
import { table } from '../../ui/table';
import type { Column } from '../../ui/table';
import type { Fit } from '../../api/types';
import type { Numbers } from './numbers';

/** The newest captures, fits and twins. Lists without rows are left out. */
export function newest(numbers: Numbers): HTMLElement {
  return h(
    'div',
    {},
    section('Newest twins', numbers.newestTwins, [
      named((twin) => twin),
      { header: 'Error', cell: (twin) => millimetres(twin.error_m), isNumeric: true },
      { header: 'Nodes', cell: (twin) => twin.node_count, isNumeric: true },
      made((twin) => twin.create_time),
      {
        header: 'Actions',
        cell: (twin) => h('a', { class: 'button small', href: `#/${twin.name}/play`, 'aria-label': playLabel(twin) }, 'Play'),
      },
    ]),
    section('Newest fits', numbers.newestFits, [
      named((fit) => fit),
      { header: 'State', cell: stateOf },
      { header: 'Error', cell: (fit) => millimetres(fit.error_m), isNumeric: true },
      made((fit) => fit.job.create_time),
    ]),
    section('Newest captures', numbers.newestCaptures, [
      named((capture) => capture),
      { header: 'State', cell: ({ verdict, ingest }) => badge(verdict ?? ingest.state) },
      made((capture) => capture.create_time),
    ]),
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
