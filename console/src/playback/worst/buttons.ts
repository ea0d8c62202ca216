import { h } from '../../ui/dom';
import { millimetres } from '../../ui/format';
import type { Errors, Place } from '../axis/errors';

/**
 * Buttons that show the frames with the largest errors of a sequence: of all, and of those that were not fitted to.
 * `isOne` is true of one of several sequences, which the words then say.
 */
export function worstButtons(errors: Errors, fps: number, isOne: boolean, show: (frame: number) => void): HTMLElement[] {
  const { main, worst, worstOfFuture } = errors;
  if (main === null || worst === null) return [];
  const button = (text: string, { frame, error }: Place): HTMLElement => {
    const title = `Frame ${frame}, ${(frame / fps).toFixed(2)} s: the largest error of ${main.label.toLowerCase()}`;
    return h('button', { type: 'button', title, onclick: () => show(frame) }, `${text} ${millimetres(error)}`);
  };
  const whole = button(isOne ? 'Worst frame of this sequence' : 'Worst frame', worst);
  if (worstOfFuture === null || worstOfFuture.frame === worst.frame) return [whole];
  return [whole, button('Worst future frame', worstOfFuture)];
}
