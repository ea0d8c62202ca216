import type { OpenPage } from '../page';
import { PlayPage } from './play_page';
import { loadTwin } from './twin';

/** The playground of a twin. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const page = new PlayPage(context, await loadTwin(context, id));
  page.connect(`/v1/twins/${encodeURIComponent(id)}/play`, true);
  return page;
};
