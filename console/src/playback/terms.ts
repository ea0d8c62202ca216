import { predictorText } from '../pages/twins/quality';
import { h } from '../ui/dom';
import { CURVES } from './axis/errors';

const TERMS: readonly (readonly [term: string, meaning: string])[] = [
  ['For fitting', 'Frames that twins of this capture were fitted to.'],
  ['Future', 'The frames after these, where a prediction is on its own.'],
  ...CURVES.map(({ label, title }) => [label, title] as const),
  [predictorText('standing_still', false), 'What the error would be if the object did not move except where it is held.'],
  [predictorText('last_residual', false), 'The prediction, moved by the error that it has in the last frame for fitting.'],
  ['Speed', 'Speed of the middle of the control points, the points that a hand or a gripper holds.'],
];

/** The terms of the page, folded away. */
export function terms(): HTMLElement {
  const items = TERMS.map(([term, meaning]) => [h('dt', {}, term), h('dd', {}, meaning)]);
  return h('details', {}, h('summary', {}, 'What the terms mean'), h('dl', { class: 'playback-terms' }, items));
}
