import type { Capture } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { placeholder, thumbnail } from '../../ui/thumbnail';
import { mayHavePicture } from './state';

/** The small picture of a capture; a placeholder where it cannot have one. */
export function capturePicture({ api, signal }: PageContext, capture: Capture): HTMLElement {
  return mayHavePicture(capture) ? thumbnail(api, `/v1/${capture.name}/thumbnail`, '', signal) : placeholder();
}
