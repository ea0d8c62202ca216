import { h } from '../ui/dom';
import { millimetres } from '../ui/format';
import type { Errors, Place } from './axis/errors';

/** Buttons that show the frames with the largest errors: of all, and of those that were not fitted to. */
export function worstButtons(errors: Errors, fps: number, show: (frame: number) => void): HTMLElement[] {
  const { main, worst, worstOfFuture } = errors;
  if (main === null || worst === null) return [];
  const button = (text: string, { frame, error }: Place): HTMLElement => {
    const title = `Frame ${frame}, ${(frame / fps).toFixed(2)} s: the largest error of ${main.label.toLowerCase()}`;
    return h('button', { type: 'button', title, onclick: () => show(frame) }, `${text} ${millimetres(error)}`);
  };
  if (worstOfFuture === null || worstOfFuture.frame === worst.frame) return [button('Worst frame', worst)];
  return [button('Worst frame', worst), button('Worst future frame', worstOfFuture)];
}
