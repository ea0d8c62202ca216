import { h } from '../ui/dom';
import { choice } from './choices';
import type { ColourBy, Look } from './look';

const FLAGS = [
  ['observed', 'Observed points', false],
  ['controls', 'Control points', false],
  ['prediction', 'Prediction', true],
  ['springs', 'Springs', true],
  ['appearance', 'Appearance', true],
  ['beside', 'Side by side', true],
] as const;

/** Controls for what is seen and how; those of a prediction show once there is one. */
export function lookControls(look: Look, hasColours: boolean, changed: () => void): HTMLElement {
  const box = ([flag, label, ofTwin]: (typeof FLAGS)[number]): HTMLElement => {
    const input = h('input', { type: 'checkbox', checked: look[flag] });
    input.addEventListener('change', () => {
      look[flag] = input.checked;
      changed();
    });
    return h('label', { class: ofTwin ? 'playback-of-twin' : null }, input, label);
  };
  const own = hasColours ? [['own', 'their own'] as const] : [];
  const colours = [['auto', 'automatic'], ...own, ['plain', 'one colour'], ['error', 'error of the prediction']] as const;
  const colour = choice('Colour of points', colours, look.colour, (value) => {
    look.colour = value as ColourBy;
    changed();
  });
  const attributes = { class: 'row playback-look', role: 'group', 'aria-label': 'What is seen' };
  return h('div', attributes, ...FLAGS.map(box), colour);
}
