import type { Capture } from '@bendtwin/client';
import { badge } from '../../ui/badge';
import type { Child } from '../../ui/dom';
import { percent } from '../../ui/format';
import { hasPoints } from '../parts/ingest';

/** States of captures, as lists are filtered by them, with their words. */
export const STATES = [
  ['good', 'good'],
  ['usable', 'usable'],
  ['unusable', 'unusable'],
  ['reading', 'being read'],
  ['masks', 'masks made'],
  ['failed', 'not read'],
] as const;

export type CaptureState = (typeof STATES)[number][0];

/** The state of a capture in one word. */
export function stateOf(capture: Capture): CaptureState {
  const { ingest, verdict } = capture;
  if (ingest.state === 'RUNNING' || ingest.state === 'QUEUED') return 'reading';
  if (verdict === 'unusable') return 'unusable';
  if (ingest.state !== 'SUCCEEDED') return 'failed';
  if (!hasPoints(capture)) return 'masks';
  return verdict === 'usable' ? 'usable' : 'good';
}

/** The state as a badge: the verdict, or how far the reading is. */
export function stateBadge(capture: Capture): Child {
  const { ingest, verdict } = capture;
  switch (stateOf(capture)) {
    case 'reading':
      if (ingest.state === 'QUEUED') return badge('waits', 'neutral');
      return [badge('reading', 'busy'), ` ${percent(ingest.progress?.fraction ?? 0)}`];
    case 'masks':
      return badge('masks made', 'warn');
    case 'failed':
      if (ingest.state === 'CANCELLED') return badge('stopped', 'neutral');
      return [verdict ? [badge(verdict), ' '] : '', badge('not read', 'bad')];
    default:
      return badge(verdict ?? '');
  }
}

/** What an ingest ends with that could not read anything. */
const UNREAD = 'UNKNOWN_CAPTURE_KIND';

/** False if a capture has certainly nothing to show; of one that was refused the API does not say whether it has images. */
export function mayHavePicture({ ingest, verdict }: Capture): boolean {
  if (ingest.state === 'SUCCEEDED') return true;
  return ingest.state === 'FAILED' && verdict !== null && verdict !== undefined && ingest.fault?.reason !== UNREAD;
}

/** Why a capture cannot be fitted; null if it can, also once it has been read. */
export function whyNoFit(capture: Capture): string | null {
  switch (stateOf(capture)) {
    case 'unusable':
      return 'its page says why';
    case 'failed':
      return capture.ingest.state === 'CANCELLED' ? 'its reading was stopped' : 'it could not be read';
    case 'masks':
      return 'it has masks, but no points yet';
    case 'reading':
      return capture.ingest.settings['until'] === 'masks' ? 'its masks are being made' : null;
    default:
      return null;
  }
}
