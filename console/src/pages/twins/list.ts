import { idOf } from '../../api/routes';
import type { Twin } from '../../api/types';
import type { OpenPage } from '../../page';
import { h, type Child } from '../../ui/dom';
import { empty } from '../../ui/empty';
import { count, millimetres, name, time } from '../../ui/format';
import { list } from '../../ui/list';
import { Selection } from '../parts/compare';
import { tagLinks } from '../parts/labels';
import { filters } from '../parts/query';
import { take } from '../upload/take';
import { levelBadge } from './level';
import type { Quality } from './quality';

/** The list of twins. */
export const open: OpenPage = (context) => {
  context.setTitle('Twins');
  const selection = new Selection('twins');
  const shown = filters(context, [], () => void twins.restart());
  const twins = list<Twin>(context, {
    caption: 'Twins',
    hidesCaption: true,
    columns: [
      {
        header: 'Name',
        orderBy: 'name',
        cell: (twin) => h('a', { href: `#/twins/${idOf(twin.name)}` }, name(twin.display_name)),
      },
      { header: 'Trust', cell: trustOf },
      { header: 'Error', orderBy: 'error', isNumeric: true, cell: ({ error_m }) => millimetres(error_m) },
      { header: 'Nodes', isNumeric: true, cell: ({ node_count }) => count(node_count) },
      { header: 'Tags', cell: ({ tags }) => tagLinks('twins', tags) },
      { header: 'Created', orderBy: 'create_time', cell: ({ create_time }) => time(create_time) },
      { header: 'Use', cell: linksOf },
      { header: 'Compare', cell: (twin) => selection.box(idOf(twin.name), twin.display_name) },
    ],
    load: async (page) => {
      const query = { ...page, ...shown.query() };
      const { twins: rows, next_page_token } = await context.api.get('/v1/twins', { query, signal: context.signal });
      return { rows, next_page_token };
    },
    empty: () =>
      Object.keys(shown.query()).length > 0
        ? empty('No twin has this text and tag.')
        : empty([
            'There are no twins yet: they come from ',
            h('a', { href: '#/fits/new' }, 'fits'),
            '. You can also drop a twin file on this page.',
          ]),
  });
  return {
    element: h(
      'div',
      {},
      h('div', { class: 'buttons' }, importer(context.api), selection.button),
      shown.element,
      twins.element,
    ),
  };
};

function trustOf({ quality }: Twin): Child {
  const level = (quality as Quality).assessment?.level;
  return levelBadge(level);
}

function linksOf(twin: Twin): Child {
  const id = idOf(twin.name);
  return h(
    'span',
    { class: 'nowrap' },
    h('a', { href: `#/twins/${id}/play`, 'aria-label': `Play with ${twin.display_name}` }, 'Play'),
    ' ',
    h('a', { href: `#/twins/${id}/view`, 'aria-label': `View ${twin.display_name}` }, 'View'),
  );
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
