import { h } from '../../ui/dom';
import { number } from '../../view3d/legend';
import type { Factors } from '../protocol/messages';
import type { Panel, Playing } from '../playing';
import { button, panel, slider } from './parts';

const FACTORS: readonly (readonly [keyof Factors, string])[] = [
  ['stiffness', 'Stiffness'],
  ['bending', 'Bending'],
  ['damping', 'Damping'],
  ['friction', 'Friction'],
  ['mass', 'Mass'],
];

/** Ground, gravity and factors of the twin's parameters. */
export function worldPanel({ model, scene, sendWorld }: Playing): Panel {
  const times = (value: number): string => `× ${number(value)}`;
  const gravity = slider('Gravity', { low: 0, high: 3 }, (value) => times(snapped(value)), (value) => {
    model.gravity = snapped(value);
    sendWorld();
  });
  const has = h('input', { type: 'checkbox', onchange: () => {
    model.ground = has.checked ? 0 : null;
    sendWorld();
  } });
  const reach = Math.max(Math.round(scene.size * 100) / 100, 0.05);
  const height = slider('Height of the ground', { low: -reach, high: reach },
    (value) => `${number(100 * value)} cm`,
    (value) => {
      model.ground = Math.abs(value) < 0.011 * reach ? 0 : value;
      sendWorld();
    });
  const factors = FACTORS.map(([name, label]) => {
    const control = slider(label, { low: 0.1, high: 10, logarithmic: true }, times, (value) => {
      const { [name]: _, ...others } = model.vary;
      model.vary = Math.abs(value - 1) < 0.03 ? others : { ...others, [name]: value };
      sendWorld();
    });
    return [name, control] as const;
  });
  const show = (): void => {
    gravity.set(model.gravity);
    has.checked = model.ground !== null;
    height.set(model.ground ?? 0);
    for (const [name, control] of factors) control.set(model.vary[name] ?? 1);
  };
  const asFitted = button('As fitted', () => {
    model.adopt(model.colliders.length > 0 ? { colliders: model.colliders } : {}, {});
    sendWorld();
    show();
  });
  show();
  return {
    element: panel('World and material', false,
      gravity.element, h('label', {}, has, ' Ground'), height.element, ...factors.map(([, f]) => f.element), asFitted),
    refresh: show,
  };
}

/** Factors near 1 are 1. */
function snapped(factor: number): number {
  return Math.abs(factor - 1) < 0.02 ? 1 : factor;
}
