import { hasEnded, type Capture } from '@bendtwin/client';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { actionButton, deleteButton, download } from '../parts/actions';
import { hasPoints } from '../parts/ingest';
import { deleteQuestion } from './dependents';

/** What is known about the masks of a recording; null where nothing can be marked, as in tracked points. */
export type Masks = 'none' | 'some' | null;

/** The main buttons of a capture in its present state, the one that leads on first. `cancel` stops its reading. */
export function mainActions(
  context: PageContext,
  capture: Capture,
  masks: Masks,
  cancel: () => Promise<void>,
  faults: HTMLElement,
): HTMLElement[] {
  const at = `#/${capture.name}`;
  const id = at.slice('#/captures/'.length);
  const link = (text: string, href: string, isPrimary: boolean): HTMLElement =>
    h('a', { class: isPrimary ? 'button primary' : 'button', href }, text);
  if (!hasEnded(capture.ingest)) return [actionButton(context, 'Stop reading', faults, cancel)];
  if (hasPoints(capture)) {
    return [
      link('Start a fit', `#/fits/new?capture=${id}`, true),
      link('Play the recording', `${at}/playback`, false),
      ...(masks === null ? [] : [link('Correct the masks', `${at}/masks`, false)]),
    ];
  }
  // Masks alone were made: fits need points.
  if (capture.ingest.state === 'SUCCEEDED') return [link('Look at the masks, and use them', `${at}/masks`, true)];
  if (masks === 'none') return [link('Mark the object and the hand', `${at}/masks`, true)];
  return masks === 'some' ? [link('Correct the masks', `${at}/masks`, false)] : [];
}

/** Downloads of a capture's files, and its deletion. */
export function fileActions(context: PageContext, capture: Capture, faults: HTMLElement): HTMLElement[] {
  const { name } = capture;
  const [path, id] = [`/v1/${name}`, name.slice('captures/'.length)];
  const file = (text: string, from: string, to: string): HTMLElement => download(context, text, `${path}/${from}`, `${id}${to}`, faults);
  return [
    file('Download the recording', 'content', '.zip'),
    ...(hasPoints(capture) ? [file('Download the observation', 'observation', '-observation.zip')] : []),
    ...(capture.masks ? [file('Download the masks', 'masks', '-masks.zip')] : []),
    ...(capture.verdict && hasEnded(capture.ingest) ? [file('Download the report as a page', 'report.html', '-report.html')] : []),
    deleteButton(context, path, () => deleteQuestion(context, [name]), '#/captures', faults),
  ];
}
