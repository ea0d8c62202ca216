import { Problem } from '@bendtwin/client';
import type { OpenPage } from '../page';
import { h } from '../ui/dom';
import { problemBox } from '../ui/problem';
import { PlaybackFile } from './file/file';
import { PlaybackPage } from './playback_page';
import '../play/play.css';
import './playback.css';

/** The playback of a capture: what was observed, what cameras saw, and what a twin predicts. */
export const open: OpenPage = async (context) => {
  const { api, signal } = context;
  const id = context.parameters['id'] ?? '';
  const capture = await api.get('/v1/captures/{id}', { id, signal });
  const title = capture.display_name || 'Capture without a name';
  context.setTitle(`Playback of ${title}`);
  let file: PlaybackFile;
  try {
    file = await PlaybackFile.open(api, id, signal);
  } catch (error) {
    if (error instanceof Problem && error.reason === 'PLAYBACK_MISSING') return { element: missing(id, error) };
    throw error;
  }
  const asked = Number(context.query.get('sequence') ?? 0);
  const index = Number.isInteger(asked) && asked in file.head.sequences ? asked : 0;
  const sequence = file.head.sequences[index];
  if (sequence === undefined) return { element: h('p', {}, 'This capture has no sequence to play.') };
  if (sequence.motion.point_count === 0) return { element: withoutPoints(id) };
  const page = await PlaybackPage.load({ context, id, name: title, file, index, sequence });
  return { element: page.element, dispose: () => page.dispose() };
};

/** Replacement for a missing playback. */
function missing(id: string, error: Problem): HTMLElement {
  return h('div', {}, problemBox(error), h('p', {}, toCapture(id)));
}

/** Replacement for points that are not there: of a recording that was refused, or read up to masks alone. */
function withoutPoints(id: string): HTMLElement {
  const text = 'This capture has no points to play: its page says what the last reading came to, and shows its images.';
  return h('div', { class: 'empty' }, h('p', {}, text), toCapture(id));
}

function toCapture(id: string): HTMLElement {
  return h('a', { class: 'button', href: `#/captures/${id}` }, 'To the capture');
}
