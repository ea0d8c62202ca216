import { h } from '../ui/dom';

const TERMS = [
  ['For fitting', 'Frames that twins of this capture were fitted to. In the future, the frames after them, a prediction is on its own.'],
  ['Tracks', 'Mean distance of predicted points from the same points as they were tracked.'],
  ['Surface L1', 'Mean distance of observed points from the predicted surface, as a sum along the three axes.'],
  ['Standing still', 'What the error would be if the object did not move except where it is held.'],
  ['With its last training error added', 'The prediction, moved by the error that it has in the last frame for fitting.'],
  ['Speed', 'Speed of the middle of the control points, the points that a hand or a gripper holds.'],
] as const;

/** The terms of the page, folded away. */
export function terms(): HTMLElement {
  const list = h('dl', { class: 'playback-terms' }, ...TERMS.map(([term, meaning]) => [h('dt', {}, term), h('dd', {}, meaning)]));
  return h('details', {}, h('summary', {}, 'What the terms mean'), list);
}
