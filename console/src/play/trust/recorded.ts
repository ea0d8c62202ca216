import type { Api } from '../../api/client';
import { Prediction } from '../../playback/prediction';
import type { Material, Strains } from './strain';

/** Most frames that the range is taken over, evenly spread. */
const MOST_FRAMES = 400;

/**
 * Strains that a twin has while it follows the recording that it was fitted to, by an evaluation on the server. They
 * are recorded nowhere, and only in these motions was the twin ever compared with its object.
 */
export async function recordedStrains(
  api: Api,
  { twin, capture, material }: { readonly twin: string; readonly capture: string; readonly material: Material },
  signal: AbortSignal,
): Promise<Strains> {
  const { all } = await Prediction.load(api, { twin, capture, sequence: 0 }, signal);
  const step = Math.max(Math.ceil(all.length / MOST_FRAMES), 1);
  return material.recorded(all.filter((_, frame) => frame % step === 0));
}
