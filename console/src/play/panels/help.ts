import { h } from '../../ui/dom';
import { panel } from './parts';

const KEYS: readonly (readonly [string, string])[] = [
  ['Drag a point of the object', 'grasps it; releasing drops it, with Shift it stays held'],
  ['Drag a gripper', 'moves it with what it holds; orange ones hold something'],
  ['Wheel while dragging', 'away from you and towards you'],
  ['Drag beside the object', 'rotates the view; right button or two fingers move it; wheel or pinch zooms'],
  ['Tab, Shift and Tab', 'the next or previous gripper; after the last one leaves the picture'],
  ['Arrows, page up and page down', 'move the selected gripper along the ground, up and down'],
  ['Space', 'grasps the nearest point, or releases it'],
  ['Shift and arrows', 'rotate the view, or move it with Control; plus and minus zoom'],
  ['Gamepad', 'left stick along the ground, right stick up and down, A grasps and releases, shoulder buttons select'],
];

/** Help for mouse, keys and gamepad. */
export function helpPanel(): HTMLElement {
  return panel('Mouse, keys and gamepad', false,
    h('dl', { class: 'keys' }, ...KEYS.flatMap(([key, effect]) => [h('dt', {}, key), h('dd', {}, effect)])));
}
