import { idOf } from '@bendtwin/client';
import { visitedTwin } from '../api/visit';
import type { PageContext } from '../page';
import { loadShape, type TwinShape } from '../view3d/shape';

/** A twin that a page shows. */
export interface ShownTwin {
  readonly id: string;
  readonly name: string;
  readonly shape: TwinShape;
  /** Id of the capture that it was fitted to; null for an imported one. */
  readonly capture: string | null;
}

/** Loads a twin, after which the page is called. */
export async function loadTwin(context: PageContext, id: string): Promise<ShownTwin> {
  const { api, signal } = context;
  const [shape, twin] = await Promise.all([loadShape(api, id, signal), api.get('/v1/twins/{id}', { id, signal })]);
  context.setTitle(twin.display_name || 'Twin');
  // A link to a twin does not lead to its recording.
  const capture = twin.capture === null || visitedTwin() !== null ? null : idOf(twin.capture);
  return { id, name: twin.display_name, shape, capture };
}
