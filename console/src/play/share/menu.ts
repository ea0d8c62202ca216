import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import type { Stage } from '../../view3d/stage';
import { download, fileName } from './download';
import { panel } from '../panels/parts';

/** Longest video [s]. */
const LONGEST_S = 60;
/** Formats of videos in the order of preference: what costs less beside the drawing comes first. */
const FORMATS = ['video/webm;codecs=vp8', 'video/webm;codecs=vp9', 'video/webm', 'video/mp4'];
/** Time after which each part of a video comes [ms]. */
const PART_MS = 1000;

/** Makes a button for a video; `say` shows what came of it. */
export type VideoButton = (say: (text: string) => void) => HTMLElement | null;

/** Buttons for a link to what is seen, a picture of it, and a video: one that films, or another one. */
export function shareMenu(
  stage: Stage,
  context: PageContext,
  query: () => URLSearchParams,
  name: string,
  video: VideoButton = (say) => videoButton(stage, context, name, say),
): HTMLElement {
  const done = h('p', { class: 'hint', role: 'status' });
  const field = h('input', { type: 'text', readonly: true, hidden: true, 'aria-label': 'Link' });
  const link = async (): Promise<void> => {
    context.setQuery(query());
    field.value = location.href;
    field.hidden = false;
    field.select();
    try {
      await navigator.clipboard.writeText(location.href);
      done.textContent = 'The link is copied. It shows this moment to users of this server.';
    } catch {
      done.textContent = 'This is the link: copy it from the field.';
    }
  };
  const twin = /^#\/twins\/([^/?]+)/.exec(location.hash)?.[1];
  const invite = async (id: string): Promise<void> => {
    const { openShares } = await import('../../pages/twins/share');
    openShares(context, id, query());
  };
  const picture = async (): Promise<void> => {
    download(await stage.picture(), fileName(name, 'png'));
    done.textContent = 'The picture is in your downloads.';
  };
  return panel('Share', true,
    h('div', { class: 'row' },
      h('button', { type: 'button', onclick: () => void link() }, 'Copy link'),
      twin !== undefined && h('button', { type: 'button', onclick: () => void invite(twin) }, 'Link for anyone'),
      h('button', { type: 'button', onclick: () => void picture() }, 'Picture'),
      video((text) => (done.textContent = text))),
    field, done);
}

/** A button that films what is seen until it is pressed again. */
function videoButton(
  stage: Stage,
  context: PageContext,
  name: string,
  say: (text: string) => void,
): HTMLElement | null {
  const type = typeof MediaRecorder === 'undefined' ? undefined : FORMATS.find((f) => MediaRecorder.isTypeSupported(f));
  if (type === undefined) return null;
  let recorder: MediaRecorder | null = null;
  const button = h('button', { type: 'button', 'aria-pressed': 'false' }, 'Video');
  const begin = (): void => {
    const stream = stage.canvas.captureStream(30);
    const mine = (recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 6_000_000 }));
    const parts: Blob[] = [];
    const began = performance.now();
    const end = setTimeout(() => mine.stop(), LONGEST_S * 1000);
    mine.addEventListener('dataavailable', ({ data }) => {
      if (data.size === 0) return;
      parts.push(data);
      button.textContent = `End the video (${Math.round((performance.now() - began) / 1000)} s)`;
    });
    mine.addEventListener('stop', () => {
      clearTimeout(end);
      stream.getTracks().forEach((track) => track.stop());
      recorder = null;
      button.textContent = 'Video';
      button.setAttribute('aria-pressed', 'false');
      if (context.signal.aborted) return;
      if (parts.length === 0) return say('Nothing is filmed yet: let it run a little longer.');
      download(new Blob(parts, { type }), fileName(name, type.startsWith('video/mp4') ? 'mp4' : 'webm'));
      say('The video is in your downloads.');
    });
    context.signal.addEventListener('abort', () => mine.state !== 'inactive' && mine.stop(), { once: true });
    mine.start(PART_MS);
    button.textContent = 'End the video';
    button.setAttribute('aria-pressed', 'true');
    say(`The picture is filmed, for at most ${LONGEST_S} s.`);
    // A picture that stands still has frames only if it is drawn.
    stage.invalidate();
  };
  button.addEventListener('click', () => (recorder === null ? begin() : recorder.stop()));
  return button;
}
