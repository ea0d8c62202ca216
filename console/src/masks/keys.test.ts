import { expect, it } from 'vitest';
import { commandOf } from './keys';

const pressed = (key: string, more: Partial<KeyboardEvent> = {}): Parameters<typeof commandOf>[0] => ({
  key, ctrlKey: false, metaKey: false, altKey: false, shiftKey: false, ...more,
});
const nowhere = { onControl: false, onText: false };

it('keys choose brushes, lead back, magnify and move in time', () => {
  const found = ['1', '2', '3', '+', '-', ',', '.', ' ', 'x'].map((key) => commandOf(pressed(key), nowhere));
  expect(found).toEqual(['object', 'hand', 'background', 'larger', 'smaller', 'back', 'on', 'toggle', null]);
  const control = { ctrlKey: true };
  expect(commandOf(pressed('z', control), nowhere)).toBe('undo');
  expect(commandOf(pressed('Z', { ...control, shiftKey: true }), nowhere)).toBe('redo');
  expect(commandOf(pressed('y', { metaKey: true }), nowhere)).toBe('redo');
  // The browser's own: another tab, and a larger page.
  expect([commandOf(pressed('1', control), nowhere), commandOf(pressed('+', control), nowhere)]).toEqual([null, null]);
});

it('keys of controls stay theirs', () => {
  expect(commandOf(pressed('1'), { onControl: true, onText: true })).toBeNull();
  expect(commandOf(pressed('z', { ctrlKey: true }), { onControl: true, onText: true })).toBeNull();
  expect(commandOf(pressed(' '), { onControl: true, onText: false })).toBeNull();
  expect(commandOf(pressed('2'), { onControl: true, onText: false })).toBe('hand');
});
