import { h } from '../../ui/dom';
import { panel } from './parts';

const KEYS: readonly (readonly [string, string])[] = [
  ['Drag a point of the object', 'takes hold of it; letting go drops it, with Shift it stays held'],
  ['Drag an orange ball', 'moves that hand'],
  ['Wheel while dragging', 'away from you and towards you'],
  ['Drag beside the object', 'turns the view; right button or two fingers move it; wheel or pinch comes closer'],
  ['Tab, Shift and Tab', 'the next or previous gripper; after the last one out of the picture'],
  ['Arrows, page up and page down', 'move the selected gripper along the ground, up and down'],
  ['Space', 'grasps the nearest point, or lets go'],
  ['Shift and arrows', 'turn the view, with Control as well they move it; plus and minus come closer and go away'],
  ['Gamepad', 'left stick along the ground, right stick up and down, A grasps and lets go, shoulder buttons select'],
];

/** Help for mouse, keys and gamepad. */
export function helpPanel(): HTMLElement {
  return panel('Mouse, keys and gamepad', false,
    h('dl', { class: 'keys' }, ...KEYS.flatMap(([key, effect]) => [h('dt', {}, key), h('dd', {}, effect)])));
}
