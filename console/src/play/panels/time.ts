import { h } from '../../ui/dom';
import type { Panel, Playing } from '../playing';
import { button, press, toggle } from './parts';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

/** Pause, single steps, speed, and the first state again. */
export function timePanel({ send, driver, scene }: Playing): Panel {
  const pause = toggle('Pause', (paused) => send({ type: 'pause', paused }));
  const speed = h('select', {
    'aria-label': 'Speed',
    onchange: () => send({ type: 'speed', factor: Number(speed.value) }),
  }, ...SPEEDS.map((factor) => h('option', { value: factor, selected: factor === 1 }, `${factor} ×`)));
  const forces = toggle('Forces', (on) => {
    scene.showsForces = on;
    scene.stage.invalidate();
  }, true);
  const reset = (): void => {
    driver.held.clear();
    for (let g = 0; g < driver.count; g += 1) driver.forget(g);
    send({ type: 'reset' });
  };
  return {
    element: h('div', { class: 'row' },
      pause,
      button('Step', () => send({ type: 'step', frames: 1 }), { title: 'Pause, and simulate one frame' }),
      button('Start again', reset),
      speed,
      forces),
    update: (facts) => {
      press(pause, facts.paused);
      if (document.activeElement !== speed && SPEEDS.includes(facts.speed)) speed.value = String(facts.speed);
    },
  };
}
