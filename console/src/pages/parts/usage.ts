import { Problem, type OwnerUsage } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { progress } from '../../ui/form';
import { count, percent, size } from '../../ui/format';
import { table } from '../../ui/table';

/** Most owners that are shown: those with most bytes, of as many as a page of the API has. */
const SHOWN = 50;
const PAGE = 1000;

/** What is stored for the owner of the key or token that is used, of its bound if it has one. */
export function ownUsage({ stored_bytes: stored, quotas }: OwnerUsage): HTMLElement {
  const bound = quotas.stored_bytes ?? null;
  if (bound === null) return h('p', { class: 'muted' }, `You have ${size(stored.total)} stored.`);
  const share = bound > 0 ? stored.total / bound : 1;
  return h(
    'div',
    {},
    h('p', { class: 'muted' }, `You have ${size(stored.total)} of ${size(bound)} stored (${percent(share)}).`),
    progress('Stored of what your key allows', Math.min(share, 1)),
    stored.total >= bound && h('p', {}, 'There is no room for more: delete captures or twins that you do not need.'),
  );
}

/** Usage of all owners; null if the key in use may not see it. */
export async function askOwners({ api, signal }: PageContext): Promise<readonly OwnerUsage[] | null> {
  try {
    return (await api.get('/v1/usage/owners', { query: { page_size: PAGE }, signal })).owners;
  } catch (error) {
    if (error instanceof Problem && error.status === 403) return null;
    throw error;
  }
}

/** A table of owners, those with most bytes first. */
export function ownersTable(owners: readonly OwnerUsage[]): HTMLElement {
  const rows = [...owners].sort((a, b) => b.stored_bytes.total - a.stored_bytes.total).slice(0, SHOWN);
  const bytes = (header: string, of: (usage: OwnerUsage) => number | null | undefined) => ({
    header,
    isNumeric: true,
    cell: (usage: OwnerUsage) => size(of(usage)),
  });
  const number = (header: string, of: (usage: OwnerUsage) => number) => ({
    header,
    isNumeric: true,
    cell: (usage: OwnerUsage) => count(of(usage)),
  });
  const caption = rows.length < owners.length ? `Usage by owner (the ${SHOWN} with most bytes)` : 'Usage by owner';
  return h(
    'section',
    {},
    h('h2', {}, caption),
    table({
      caption,
      hidesCaption: true,
      rows,
      columns: [
        { header: 'Owner', cell: ({ owner }) => (owner === '' ? 'nobody' : h('bdi', {}, owner)) },
        bytes('Stored', (usage) => usage.stored_bytes.total),
        bytes('Allowed', (usage) => usage.quotas.stored_bytes),
        bytes('Captures', (usage) => usage.stored_bytes.captures),
        bytes('Made of them', (usage) => usage.stored_bytes.derived),
        bytes('Twins', (usage) => usage.stored_bytes.twins),
        bytes('Checkpoints', (usage) => usage.stored_bytes.checkpoints),
        bytes('Uploads', (usage) => usage.stored_bytes.uploads),
        number('Jobs waiting', (usage) => usage.queued_jobs),
        number('Jobs running', (usage) => usage.running_jobs),
      ],
    }),
  );
}
