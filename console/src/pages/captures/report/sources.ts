import { h } from '../../../ui/dom';
import { counted } from '../../../ui/format';
import { prose } from '../../parts/text';
import type { Report } from './report';

type Sources = NonNullable<Report['sources']>;

/** What was taken as what, part by part, and what was left out; null without any. */
export function sourcesView(sources: Report['sources']): HTMLElement | null {
  if (!sources || sources.taken.length + sources.left_out.length === 0) return null;
  const { taken, left_out: left } = sources;
  const count = left.length === 0 ? '' : `, ${left.length} left out`;
  return h(
    'details',
    { class: 'card' },
    h('summary', {}, `What was read: ${counted(taken.length, 'part')}${count}`),
    taken.length > 0 && h('ul', { class: 'sources' }, ...taken.map(takenRow)),
    left.length > 0 && [
      h('h3', {}, 'Left out'),
      h('ul', { class: 'sources' }, ...left.map(({ from, because }) => h('li', {}, path(from), ': ', prose(because)))),
    ],
  );
}

function takenRow({ part, camera, from, form }: Sources['taken'][number]): HTMLElement {
  const whose = camera === null ? '' : [' of ', h('bdi', {}, camera)];
  return h('li', {}, h('strong', {}, part), whose, ': ', path(from), form !== '' && [' (', prose(form), ')']);
}

function path(text: string): HTMLElement {
  return h('code', {}, h('bdi', {}, text));
}
