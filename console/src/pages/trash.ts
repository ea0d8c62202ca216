import { idOf, type TrashedResource } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../page';
import { confirm } from '../ui/dialog';
import { h } from '../ui/dom';
import { empty } from '../ui/empty';
import { name, size, time } from '../ui/format';
import { list, type List } from '../ui/list';
import { actionButton, faultPlace } from './parts/actions';

/** What the trash has a list of. */
const KINDS = ['captures', 'fits', 'twins'] as const;
type Kind = (typeof KINDS)[number];

/** Deleted captures, fits and twins, which can be restored. */
export const open: OpenPage = (context) => {
  context.setTitle('Trash');
  const about = 'What was deleted can be restored until the time that stands beside it; then it is gone for good.';
  return { element: h('div', {}, h('p', { class: 'muted' }, about), ...KINDS.map((kind) => section(context, kind))) };
};

function section(context: PageContext, kind: Kind): HTMLElement {
  const faults = faultPlace();
  const title = kind.charAt(0).toUpperCase() + kind.slice(1);
  const trashed: List = list<TrashedResource>(context, {
    caption: `Deleted ${kind}`,
    hidesCaption: true,
    columns: [
      { header: 'Name', cell: ({ display_name }) => name(display_name) },
      { header: 'Deleted', cell: ({ delete_time }) => time(delete_time) },
      { header: 'By', cell: ({ deleted_by }) => h('bdi', {}, deleted_by) },
      { header: 'Until', cell: ({ purge_time }) => time(purge_time) },
      { header: 'Size', isNumeric: true, cell: ({ size_bytes }) => (size_bytes === 0 ? '–' : size(size_bytes)) },
      { header: 'Actions', cell: (row) => buttons(context, kind, row, trashed, faults) },
    ],
    load: async ({ page_token }) => {
      const { signal } = context;
      const query = { page_token };
      const page = await context.api.get(`/v1/trash/${kind}`, { query, signal });
      return { rows: page.resources, next_page_token: page.next_page_token };
    },
    empty: () => empty(`No deleted ${kind}.`),
  });
  return h('section', {}, h('h2', {}, title), faults, trashed.element);
}

function buttons(
  context: PageContext,
  kind: Kind,
  { name: resource, display_name: shown }: TrashedResource,
  trashed: List,
  faults: HTMLElement,
): HTMLElement {
  const path = `/v1/${kind}/${idOf(resource)}`;
  const restore = async (): Promise<void> => {
    await context.api.send('POST', `${path}/undelete`, {}, context.signal);
    context.announce(`Restored ${shown}`);
    await trashed.reload();
  };
  const purge = async (): Promise<void> => {
    const title = `Delete ${shown} for good?`;
    const text = 'Nothing can restore it then.';
    if (!(await confirm({ title, text, action: 'Delete for good', isDangerous: true }))) return;
    await context.api.fetch(`${path}?purge=true`, { method: 'DELETE', signal: context.signal });
    context.announce('Deleted for good');
    await trashed.reload();
  };
  const restoring = actionButton(context, 'Restore', faults, restore, 'small');
  restoring.setAttribute('aria-label', `Restore ${shown}`);
  const purging = actionButton(context, 'Delete for good', faults, purge, 'small danger');
  purging.setAttribute('aria-label', `Delete ${shown} for good`);
  return h('span', { class: 'nowrap' }, restoring, ' ', purging);
}
