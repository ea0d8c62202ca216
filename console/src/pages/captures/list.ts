import { hasEnded, idOf, type Capture } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { h, type Child } from '../../ui/dom';
import { cli, empty } from '../../ui/empty';
import { count, counted, name, size, time } from '../../ui/format';
import { list, totalOf, type ListPage, type PageQuery } from '../../ui/list';
import { refresh } from '../../ui/refresh';
import { ERROR_HELP, errorCell } from '../parts/error';
import { tagLinks } from '../parts/labels';
import { filters } from '../parts/query';
import { MultiSelection } from '../parts/selection';
import { deleteQuestion } from './dependents';
import { Fits, type Best } from './fits';
import { capturePicture } from './picture';
import { STATES, stateBadge, stateOf, whyNoFit } from './state';
import './named.css';

/** Interval at which captures that are being read are refreshed [ms]. */
const REFRESH_MS = 2000;
/** Captures requested together where the page chooses among them, and how many of its own are then shown. */
const MANY = 1000;
const ENOUGH = 50;

const CHOICE = { name: 'state', label: 'State', values: [['', 'all'], ...STATES] } as const;

/** The list of captures. */
export const open: OpenPage = (context) => {
  context.setTitle('Captures');
  let isReading = false;
  let fits: Fits | null = null;
  const shown = filters(context, [CHOICE], () => void captures.restart());
  const selection = new MultiSelection(context, {
    noun: 'capture',
    question: (rows) => deleteQuestion(context, rows.map((row) => row.name)),
    onChange: () => void captures.reload(),
  });
  const captures = list<Capture>(context, {
    caption: 'Captures',
    hidesCaption: true,
    noun: 'capture',
    filtered: shown.words,
    columns: [
      { header: 'Name', orderBy: 'name', cell: (capture) => nameCell(context, selection, capture) },
      { header: 'State', cell: stateBadge },
      { header: 'Fits', isNumeric: true, cell: ({ name: own }) => fits?.count(own) ?? '' },
      { header: 'Best error', help: ERROR_HELP, isNumeric: true, cell: ({ name: own }) => bestError(fits?.best(own)) },
      { header: 'Tags', cell: ({ tags }) => tagLinks('captures', tags) },
      { header: 'Size', isNumeric: true, cell: ({ size_bytes }) => size(size_bytes) },
      { header: 'Uploaded', orderBy: 'create_time', cell: ({ create_time }) => time(create_time) },
      { header: 'Start', cell: fitLink },
    ],
    load: async (page) => {
      const { state, ...query } = shown.query();
      const loaded = await loadPage(context, { ...page, ...query }, state, shown.words);
      isReading = loaded.rows.some(({ ingest }) => !hasEnded(ingest));
      return loaded;
    },
    empty: () =>
      Object.keys(shown.query()).length > 0
        ? empty('No capture matches.')
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
  Fits.load(context).then(
    (loaded) => {
      fits = loaded;
      return captures.reload();
    },
    // The list is complete without them.
    () => undefined,
  );
  const upload = h('div', { class: 'buttons' }, h('a', { class: 'button primary', href: '#/upload' }, 'Upload'));
  return { element: h('div', {}, upload, shown.element, captures.element, selection.element) };
};

/** A page of captures; of those in one state the page finds them itself, for the API does not filter by it. */
async function loadPage(
  { api, signal }: PageContext,
  query: PageQuery,
  state: string | undefined,
  words: () => string,
): Promise<ListPage<Capture>> {
  if (state === undefined) {
    const reply = await api.get('/v1/captures', { query, signal });
    return { rows: reply.captures, next_page_token: reply.next_page_token, total_size: totalOf(reply) };
  }
  const rows: Capture[] = [];
  let page_token = query.page_token;
  let seen = 0;
  do {
    const reply = await api.get('/v1/captures', { query: { ...query, page_token, page_size: MANY }, signal });
    seen += reply.captures.length;
    rows.push(...reply.captures.filter((capture) => stateOf(capture) === state));
    page_token = reply.next_page_token;
  } while (page_token !== '' && rows.length < ENOUGH);
  const isWhole = page_token === '' && query.page_token === '';
  const remark = `${counted(rows.length, 'capture')}${words()} among the ${count(seen)} that this page looked through.`;
  return { rows, next_page_token: page_token, remark: isWhole ? undefined : remark };
}

function nameCell(context: PageContext, selection: MultiSelection, capture: Capture): HTMLElement {
  const link = h('a', { href: `#/captures/${idOf(capture.name)}` }, name(capture.display_name));
  return h('span', { class: 'capture-name' }, selection.box(capture), capturePicture(context, capture), link);
}

function bestError(best: Best | null | undefined): Child {
  return errorCell(best?.error_m, best?.measure);
}

function fitLink(capture: Capture): Child {
  if (whyNoFit(capture) !== null) return '';
  const query = new URLSearchParams({ capture: idOf(capture.name) });
  return h('a', { href: `#/fits/new?${query}`, 'aria-label': `Fit ${capture.display_name}` }, 'Fit');
}
