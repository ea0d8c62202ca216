import { idOf, Problem, type Capture } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { name } from '../../ui/format';

/** The capture that a fit or a twin is of, or null if it was deleted. */
export async function findCapture({ api, signal }: PageContext, resource: string): Promise<Capture | null> {
  try {
    return await api.get('/v1/captures/{id}', { id: idOf(resource), signal });
  } catch (error) {
    if (error instanceof Problem && error.status === 404) return null;
    throw error;
  }
}

/** The capture by its name, with a link if it is still there. */
export function captureText(capture: Capture | null): HTMLElement {
  if (capture === null) return h('i', { class: 'muted' }, 'deleted');
  return h('a', { href: `#/captures/${idOf(capture.name)}` }, name(capture.display_name));
}

/** A link to a capture, with its name once that is known. */
export function captureLink(context: PageContext, resource: string): HTMLElement {
  const place = h('span', {}, h('a', { href: `#/${resource}` }, idOf(resource)));
  findCapture(context, resource).then(
    (capture) => place.replaceChildren(captureText(capture)),
    () => undefined,
  );
  return place;
}
