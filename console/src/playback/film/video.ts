import { download, fileName } from '../../play/share/download';
import { h } from '../../ui/dom';
import { compose, layoutOf, type Layout, type Panel } from './compose';
import { Encoder } from './encoder';
import { paceOf } from './pace';

/** What a video is made of. */
export interface Subject {
  /** Name of the file. */
  readonly name: string;
  readonly frameCount: number;
  readonly fps: number;
  /** Factor of the recording's speed. */
  readonly speed: number;
  /** Aborted when the page is left. */
  readonly signal: AbortSignal;
  /** Loads and draws a frame. */
  draw(frame: number): Promise<void>;
  /** Pictures of the frame that was drawn, which stay until the end of the task. */
  panels(): Panel[];
  /** Texts at both ends of the bar. */
  texts(frame: number): readonly [left: string, right: string];
  /** Called at the end: shows what was shown before. */
  end(): void;
}

/** A button that makes a video of all frames, for browsers that encode videos. */
export function videoButton(subject: () => Subject, say: (text: string) => void): HTMLElement {
  const press = async (): Promise<void> => {
    const mine = subject();
    try {
      const video = await make(mine);
      if (video === null) return say('The video was given up.');
      download(video, fileName(mine.name, 'webm'));
      say('The video is in your downloads.');
    } catch (error) {
      say(`The video failed: ${error instanceof Error ? error.message : String(error)}`);
    } finally {
      mine.end();
    }
  };
  const title = 'A video of all frames: the image of the camera beside the picture in three dimensions';
  return h('button', { type: 'button', title, onclick: () => void press() }, 'Video');
}

/** Makes the video in a dialog that shows how far it is; null if that is given up. */
async function make(subject: Subject): Promise<Blob | null> {
  const { signal, frameCount, fps, speed } = subject;
  const { frames, seconds } = paceOf(frameCount, fps, speed);
  const canvas = h('canvas', { class: 'film-canvas', role: 'img', 'aria-label': 'The picture that is encoded' });
  const progress = h('progress', { max: frames.length, value: 0, 'aria-label': 'Encoded frames' });
  const words = h('p', { class: 'hint' });
  const dialog = h('dialog', { class: 'film', 'aria-labelledby': 'film-title' },
    h('h2', { id: 'film-title', class: 'first' }, 'Making the video'),
    canvas, progress, words,
    h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: () => dialog.close() }, 'Cancel')));
  const close = (): void => dialog.close();
  signal.addEventListener('abort', close, { once: true });
  document.body.append(dialog);
  dialog.showModal();
  let film: Film | null = null;
  try {
    for (const [done, frame] of frames.entries()) {
      progress.value = done;
      words.textContent = `${done} of ${frames.length} frames`;
      await subject.draw(frame);
      // The page stays alive meanwhile, and shows how far it is.
      await new Promise((resolve) => setTimeout(resolve));
      if (!dialog.open) return null;
      film ??= await Film.begin(canvas, subject, seconds);
      await film.add(frame);
    }
    return (await film?.finish()) ?? null;
  } finally {
    film?.close();
    signal.removeEventListener('abort', close);
    dialog.close();
    dialog.remove();
  }
}

/** Pictures of a subject, laid out as the first of them was. */
class Film {
  private constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly context: CanvasRenderingContext2D,
    private readonly subject: Subject,
    private readonly layout: Layout,
    private readonly encoder: Encoder,
  ) {}

  static async begin(canvas: HTMLCanvasElement, subject: Subject, seconds: number): Promise<Film> {
    const layout = layoutOf(subject.panels().map(({ source }) => source.width / Math.max(source.height, 1)));
    canvas.width = layout.width;
    canvas.height = layout.height;
    const context = canvas.getContext('2d', { alpha: false });
    if (context === null) throw new Error('this browser has no canvas for it');
    return new Film(canvas, context, subject, layout, await Encoder.begin(layout.width, layout.height, seconds));
  }

  async add(frame: number): Promise<void> {
    compose(this.context, this.layout, this.subject.panels(), this.subject.texts(frame));
    await this.encoder.add(this.canvas);
  }

  finish(): Promise<Blob> {
    return this.encoder.finish();
  }

  close(): void {
    this.encoder.close();
  }
}
