import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { picturesOf } from './report';

/** The pictures of a report, loaded when they are come near: a report's page may have megabytes. */
export function picturesView(context: PageContext, id: string): HTMLElement {
  const element = h('section', {}, h('h2', {}, 'Pictures'));
  const load = async (): Promise<void> => {
    try {
      const answer = await context.api.fetch(`/v1/captures/${id}/report.html`, { signal: context.signal });
      const figures = picturesOf(await answer.text()).map(({ source, title, caption }) =>
        h(
          'figure',
          {},
          h('img', { src: source, alt: title, loading: 'lazy' }),
          h('figcaption', { class: 'muted' }, caption),
        ),
      );
      element.append(h('div', { class: 'pictures' }, ...figures));
      element.hidden = figures.length === 0;
    } catch {
      // Without a report there is no page; the fault is shown above.
      element.hidden = true;
    }
  };
  const near = new IntersectionObserver(
    (entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      near.disconnect();
      void load();
    },
    { rootMargin: '300px' },
  );
  near.observe(element);
  context.signal.addEventListener('abort', () => near.disconnect());
  return element;
}
