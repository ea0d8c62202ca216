import type { PageContext } from '../../../page';
import { h } from '../../../ui/dom';
import { picturesOf, type Picture } from './report';

/** The pictures of a report, loaded when they are come near: a report's page may have megabytes. */
export function picturesView({ api, signal }: PageContext, id: string): HTMLElement {
  const element = h('section', {}, h('h2', {}, 'Pictures'));
  const load = async (): Promise<void> => {
    try {
      const answer = await api.fetch(`/v1/captures/${id}/report.html`, { signal });
      const figures = picturesOf(await answer.text()).map(figureOf);
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
  signal.addEventListener('abort', () => near.disconnect());
  return element;
}

/** A picture as a button that shows it in full. */
function figureOf({ source, title, caption }: Picture): HTMLElement {
  const show = (): void => enlarge(source, title, caption);
  const button = h('button', { type: 'button', class: 'picture', onclick: show, 'aria-label': `Enlarge: ${title || caption}` },
    h('img', { src: source, alt: '', loading: 'lazy' }));
  return h('figure', {}, button, h('figcaption', { class: 'muted' }, caption));
}

function enlarge(source: string, title: string, caption: string): void {
  const close = (): void => dialog.close();
  const dialog = h(
    'dialog',
    { class: 'dialog picture-dialog', 'aria-label': title || caption },
    h('img', { src: source, alt: title }),
    h('p', { class: 'muted' }, caption),
    h('div', { class: 'buttons' }, h('button', { type: 'button', autofocus: true, onclick: close }, 'Close')),
  );
  dialog.addEventListener('close', () => dialog.remove());
  addEventListener('hashchange', close, { once: true });
  document.body.append(dialog);
  dialog.showModal();
}
