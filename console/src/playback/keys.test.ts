import { describe, expect, it } from 'vitest';
import { keyOf, keysText } from './keys';

/** A key pressed on an element that matches some of the selectors which are asked for. */
function press(key: string, on: string | null = null, changes: object = {}): KeyboardEvent {
  const closest = (selector: string): object | null => {
    return on !== null && selector.split(/, (?![^(]*\))/).some((each) => each === on) ? {} : null;
  };
  return { key, target: { closest }, ...changes } as unknown as KeyboardEvent;
}

describe('keys of the page', () => {
  it('play, step and choose cameras', () => {
    expect([' ', ',', '.', '1', '9', '0', 'a'].map((key) => keyOf(press(key)))).toEqual(['toggle', 'back', 'on', 0, 8, null, null]);
  });

  it('are named as far as there are cameras for them', () => {
    expect(keysText(1)).not.toContain('camera');
    expect(keysText(3)).toContain('1 to 3 choose a camera');
    expect(keysText(12)).toContain('1 to 9 choose a camera');
  });

  it('are left to controls that need them', () => {
    expect([' ', '3', '.'].map((key) => keyOf(press(key, 'select')))).toEqual([null, null, null]);
    expect([' ', '3', '.'].map((key) => keyOf(press(key, 'button')))).toEqual([null, 2, 'on']);
    expect(keyOf(press('1', null, { ctrlKey: true }))).toBeNull();
  });
});
