import type { OpenPage, Page, PageContext } from '../page';
import { loadShape } from '../view3d/shape';
import { PlayPage } from './play_page';

/** Part of a twin's reply that is shown. */
interface TwinReply {
  readonly display_name: string;
}

/** The playground of a twin. */
export const open: OpenPage = async (context) => {
  const id = encodeURIComponent(context.parameters['id'] ?? '');
  const page = await openTwin(context, id);
  page.connect(`/v1/twins/${id}/play`, true);
  return page;
};

/** A page of a twin, without a play yet. */
export async function openTwin(context: PageContext, id: string): Promise<PlayPage & Page> {
  const [shape, twin] = await Promise.all([
    loadShape(context.api, id, context.signal),
    context.api.json<TwinReply>(`/v1/twins/${id}`, { signal: context.signal }),
  ]);
  context.setTitle(twin.display_name || 'Twin');
  return new PlayPage(context, shape, twin.display_name, id);
}
