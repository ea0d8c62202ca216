import { Problem } from '@bendtwin/client';
import type { PageContext } from '../../../page';
import { Images } from '../../../playback/camera/images';
import { PlaybackFile } from '../../../playback/file/file';
import { hasSeveralRecordings, type CameraHead } from '../../../playback/file/head';
import { h } from '../../../ui/dom';

/** Cameras whose first images are shown. */
const MOST = 12;

/** The first images of a recording's cameras. */
export interface FirstImages {
  readonly element: HTMLElement;
  /** True if some camera has masks. */
  readonly hasMasks: boolean;
  /** True if it can be marked: it is not several recordings. */
  readonly canMark: boolean;
}

/** The first image of each camera, also of a recording that was refused; null without images. */
export async function firstImages(context: PageContext, id: string): Promise<FirstImages | null> {
  let file: PlaybackFile;
  try {
    file = await PlaybackFile.open(context.api, id, context.signal);
  } catch (error) {
    if (error instanceof Problem && error.reason === 'PLAYBACK_MISSING') return null;
    throw error;
  }
  const cameras = file.head.sequences[0]?.cameras ?? [];
  if (cameras.length === 0) return null;
  const figures = cameras.slice(0, MOST).map((camera) => figureOf(context, camera, file));
  const element = h('section', {}, h('h2', {}, 'First images'), h('div', { class: 'first-images' }, ...figures));
  return { element, hasMasks: cameras.some(({ masks }) => masks), canMark: !hasSeveralRecordings(file.head) };
}

function figureOf({ signal }: PageContext, camera: CameraHead, file: PlaybackFile): HTMLElement {
  const canvas = h('canvas', { role: 'img', 'aria-label': `First image of camera ${camera.name}` });
  const [columns, rows] = camera.images.size;
  canvas.width = columns;
  canvas.height = rows;
  const images = new Images(camera, file.read.bind(file), undefined, 1);
  const caption = h('figcaption', { class: 'muted' }, h('bdi', {}, camera.name));
  void images.load(0).then(
    () => {
      const image = images.at(0);
      if (image) canvas.getContext('2d')?.drawImage(image, 0, 0, columns, rows);
      else caption.append(': no image was recorded in the first frame');
      images.dispose();
    },
    // Read again meanwhile, or the server is gone: the page itself says so.
    () => signal.aborted || caption.append(': the image cannot be fetched'),
  );
  return h('figure', {}, canvas, caption);
}
