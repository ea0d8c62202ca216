import { idOf, type Twin } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { h, type Child } from '../../ui/dom';
import { empty, lesson } from '../../ui/empty';
import { count, name, time } from '../../ui/format';
import { list, totalOf } from '../../ui/list';
import { thumbnail } from '../../ui/thumbnail';
import { MOST } from '../parts/compare';
import { ERROR_HELP } from '../parts/error';
import { tagLinks } from '../parts/labels';
import { filters } from '../parts/query';
import { MultiSelection, type Selectable } from '../parts/selection';
import { take } from '../upload/take';
import { LEVELS, levelBadge } from './verdict/level';
import { twinErrorCell, type Quality } from './quality';

/** Twins of a page of the list. */
const PAGE_SIZE = 100;

const VERDICTS = {
  name: 'level',
  label: 'Verdict',
  values: [['', 'all'], ...LEVELS.map((level) => [level, level] as const)],
} as const;

/** The list of twins. */
export const open: OpenPage = (context) => {
  context.setTitle('Twins');
  const shown = filters(context, [VERDICTS], () => void twins.restart());
  const selection = new MultiSelection(context, {
    noun: 'twin',
    question: (rows) => ({
      title: rows.length > 1 ? `Delete ${rows.length} twins?` : 'Delete this twin?',
      text: `${rows.length > 1 ? 'They go' : 'It goes'} to the trash, if this server has one. Captures and fits are kept.`,
    }),
    onChange: () => void twins.reload(),
    actions: compareLink,
  });
  const twins = list<Twin>(context, {
    caption: 'Twins',
    hidesCaption: true,
    noun: 'twin',
    filtered: shown.words,
    columns: [
      { header: 'Name', orderBy: 'name', cell: (twin) => nameCell(context, selection, twin) },
      { header: 'Verdict', cell: ({ quality }) => levelBadge((quality as Quality).assessment?.level) },
      { header: 'Error', help: ERROR_HELP, orderBy: 'error', isNumeric: true, cell: twinErrorCell },
      { header: 'Nodes', isNumeric: true, cell: ({ node_count }) => count(node_count) },
      { header: 'Tags', cell: ({ tags }) => tagLinks('twins', tags) },
      { header: 'Created', orderBy: 'create_time', cell: ({ create_time }) => time(create_time) },
      { header: 'Use', cell: playLink },
    ],
    load: async (page) => {
      const query = { ...page, ...shown.query(), page_size: PAGE_SIZE };
      const reply = await context.api.get('/v1/twins', { query, signal: context.signal });
      return { rows: reply.twins, next_page_token: reply.next_page_token, total_size: totalOf(reply) };
    },
    empty: () =>
      Object.keys(shown.query()).length > 0
        ? empty('No twin matches: change the filters above.')
        : lesson({
            title: 'No twins yet',
            text:
              'A twin is a model of a soft object that moves as the object did in its recording, and answers how it would ' +
              'move otherwise. It is made by a fit. You can also drop a twin file on this page.',
            action: h('a', { class: 'button primary', href: '#/fits/new' }, 'Start a fit'),
          }),
  });
  shown.element.append(h('div', { class: 'buttons' }, importer(context.api)));
  return { element: h('div', {}, shown.element, twins.element, selection.element) };
};

function nameCell({ api, signal }: PageContext, selection: MultiSelection, twin: Twin): HTMLElement {
  const picture = thumbnail(api, `/v1/${twin.name}/thumbnail`, '', signal);
  const link = h('a', { href: `#/twins/${idOf(twin.name)}` }, name(twin.display_name));
  return h('span', { class: 'row-name' }, selection.box(twin), picture, link);
}

/** A link to the comparison of rows, once there are enough and not too many. */
function compareLink(rows: readonly Selectable[]): Child {
  if (rows.length < 2) return h('span', { class: 'muted' }, 'Select another one to compare.');
  if (rows.length > MOST) return h('span', { class: 'muted' }, `At most ${MOST} can be compared.`);
  const ids = rows.map((row) => idOf(row.name)).join(',');
  return h('a', { class: 'button small primary', href: `#/twins/compare?ids=${ids}` }, 'Compare');
}

function playLink({ name: resource, display_name }: Twin): Child {
  return h('a', { class: 'button small', href: `#/twins/${idOf(resource)}/play`, 'aria-label': `Play with ${display_name}` }, 'Play');
}

/** A button that imports the file of a twin. */
function importer(api: Parameters<typeof take>[0]): HTMLElement[] {
  const input = h('input', {
    type: 'file',
    hidden: true,
    accept: '.safetensors,.twin',
    'aria-label': 'File of a twin',
  });
  input.addEventListener('change', () => {
    take(api, [...(input.files ?? [])]);
    input.value = '';
  });
  return [h('button', { type: 'button', onclick: () => input.click() }, 'Import a file'), input];
}
