import type { PageContext } from '../page';
import { loadShape, type TwinShape } from '../view3d/shape';

/** Loads the shape and the name of a twin, by which the page is called. */
export async function loadTwin(context: PageContext, id: string): Promise<{ shape: TwinShape; name: string }> {
  const { api, signal } = context;
  const [shape, twin] = await Promise.all([loadShape(api, id, signal), api.get('/v1/twins/{id}', { id, signal })]);
  context.setTitle(twin.display_name || 'Twin');
  return { shape, name: twin.display_name };
}
